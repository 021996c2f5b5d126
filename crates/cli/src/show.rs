//! A summary as tables.

use gimage_bundle::manifest::{Cut, Quality, Repair};
use serde_json::Value;

use crate::output::{Output, plain};
use crate::summary::Summary;
use crate::table::{NOTHING, Table};
use crate::timings::Stage;
use crate::units;
use crate::units::{area, bytes, grouped, length, mass, percent, significant, time};

/// How many accessories are listed without `--verbose`.
const SOME: usize = 10;

/// `value`, shown, or a dash.
fn or_dash<T>(value: Option<T>, show: impl Fn(T) -> String) -> String {
    value.map_or(NOTHING.into(), show)
}

/// A heading and what stands under it; nothing where there is nothing.
fn section(out: &Output, heading: &str, body: &str) -> String {
    if body.is_empty() { String::new() } else { format!("\n{}\n{body}", out.heading(heading)) }
}

/// The text that both `build` and `inspect` print: the pieces and their quality.
pub fn overview(out: &Output, path: &str, summary: &Summary) -> String {
    let pieces = summary.pieces.len();
    let mut text = format!(
        "{}  {pieces} {}, {} texels, {} of images, from {}\n",
        out.heading(&plain(path)),
        if pieces == 1 { "piece" } else { "pieces" },
        grouped(summary.texels.into()),
        bytes(summary.image_bytes),
        plain(&summary.source.file),
    );
    text += &section(out, "Pieces", &sizes(summary).render());
    text += &section(out, "Bounding box", &boxes(summary).render());
    text += &section(out, "Surface", &surfaces(summary).render());
    text += &section(out, "Limits", &limits(summary).render());
    text += &section(out, "Seams", &seams(summary).render());
    text += &section(out, "Distortion of the map", &distortion(summary).render());
    text += &section(out, "Distance from the source", &fidelity(summary).render());
    text += &section(out, "Render mesh", &render_mesh(summary).render());
    text + &section(out, "Rating", &ratings(summary).render())
}

/// The mesh of the source.
fn render_mesh(summary: &Summary) -> Table {
    let mut table = Table::new(&["<file", "vertices", "bound", "largest offset", "size"]);
    if let Some(r) = &summary.render {
        table.row([
            r.file.clone(),
            grouped(r.vertices),
            grouped(r.bound),
            length(r.largest_offset),
            or_dash(r.bytes, bytes),
        ]);
    }
    table
}

/// Each piece in words, and why.
fn ratings(summary: &Summary) -> Table {
    let mut table = Table::new(&["<piece", "<rating", "<why"]);
    for p in &summary.pieces {
        table.row([p.name.clone(), p.rating.words().into(), p.remarks.join(", ")]);
    }
    table
}

/// The rungs tried for the pieces whose first image did not pass.
fn ladders(summary: &Summary) -> Table {
    let mut table = Table::new(&["<piece", "<tried", "PSNR at least", "<"]);
    for p in &summary.pieces {
        for r in &p.ladder {
            let kept = if r.kept { "kept" } else { "" };
            let psnr = or_dash(r.psnr, |x| format!("{x:.1} dB"));
            table.row([p.name.clone(), r.rung.clone(), psnr, kept.into()]);
        }
    }
    table
}

/// The text that `inspect` adds.
pub fn details(out: &Output, summary: &Summary) -> String {
    let mut text = section(out, "Maps", &maps(summary).render());
    text += &section(out, "Ladder", &ladders(summary).render());
    let (heading, listed) = accessories(out, summary);
    text += &section(out, &heading, &listed);
    text += &section(out, "Repairs", &repairs(&summary.repairs));
    let mut table = Table::new(&["<", "<"]);
    table.row(["file".into(), summary.source.file.clone()]);
    table.row(["sha256".into(), summary.source.sha256.clone()]);
    summary.source.extras.iter().for_each(|extra| table.row(["extra".into(), extra.clone()]));
    table.row(["made by".into(), summary.generator.clone()]);
    text += &section(out, "Source", &table.render());
    text + &section(out, "Options", &options(summary).render())
}

fn sizes(summary: &Summary) -> Table {
    let mut table =
        Table::new(&["<piece", "size", "particles", "pinned", "springs", "mass", "rest lengths", "density"]);
    for p in &summary.pieces {
        table.row([
            p.name.clone(),
            format!("{} x {}", p.width, p.height),
            grouped(p.counts.particles.into()),
            grouped(p.counts.pinned.into()),
            grouped(p.counts.springs.into()),
            or_dash(p.constants.mass, |m| mass(m.into())),
            or_dash(p.constants.rest, |r| r.map(|x| length(x.into())).join(", ")),
            or_dash(p.constants.density, |d| format!("{} kg/m²", significant(d, 3))),
        ]);
    }
    table
}

/// The numbers that pin expressions are about, in metres whatever their size.
fn boxes(summary: &Summary) -> Table {
    let mut table = Table::new(&["<piece", "x", "y", "z"]);
    let all = (summary.pieces.len() != 1).then_some(("all", &summary.bounds));
    for (name, bounds) in summary.pieces.iter().map(|p| (p.name.as_str(), &p.bounds)).chain(all) {
        let side = |k: usize| {
            or_dash(bounds.as_ref(), |b| {
                let [lo, hi] = [b.min[k], b.max[k]].map(|x| significant(x.into(), 4));
                format!("{lo} to {hi} m")
            })
        };
        table.row([name.into(), side(0), side(1), side(2)]);
    }
    table
}

/// The pieces with particles that may only move so far.
fn limits(summary: &Summary) -> Table {
    let mut table = Table::new(&["<piece", "limited particles", "shortest limit", "longest limit"]);
    for (name, limits) in summary.pieces.iter().filter_map(|p| Some((&p.name, p.limits?))) {
        let [shortest, longest] = [limits.min, limits.max].map(|x| length(x.into()));
        table.row([name.clone(), grouped(limits.particles.into()), shortest, longest]);
    }
    table
}

fn surfaces(summary: &Summary) -> Table {
    let mut table = Table::new(&["<piece", "triangles", "area", "Euler", "loops"]);
    for p in &summary.pieces {
        let s = p.surface.as_ref();
        table.row([
            p.name.clone(),
            or_dash(s, |s| grouped(s.triangles.into())),
            or_dash(s.map(|s| s.area).or(p.constants.area), area),
            or_dash(s, |s| s.euler.to_string()),
            or_dash(s, |s| s.loops.to_string()),
        ]);
    }
    table
}

fn seams(summary: &Summary) -> Table {
    let headings =
        ["<piece", "cut", "edges", "seam texels", "seam points", "largest ring", "gap", "distortion", "<method"];
    let mut table = Table::new(&headings);
    for p in &summary.pieces {
        let (cut, counts) = (p.cut.as_ref(), &p.counts);
        table.row([
            p.name.clone(),
            or_dash(cut, |cut| length(cut.length)),
            or_dash(cut, |cut| grouped(cut.edges.into())),
            grouped(counts.seam_texels.into()),
            grouped(counts.seam_points.into()),
            grouped(counts.largest_ring.into()),
            or_dash(p.quality.seam_gap, length),
            or_dash(cut, bought),
            or_dash(cut, |cut| cut.method.clone()),
        ]);
    }
    if summary.pieces.len() != 1 {
        let mut row = vec![NOTHING.to_owned(); headings.len()];
        (row[0], row[6]) = ("all".into(), length(summary.seam_gap));
        table.row(row);
    }
    table
}

/// Each piece, and the whole where there is more than one.
fn qualities(summary: &Summary) -> impl Iterator<Item = (String, &Quality)> {
    let all = (summary.pieces.len() != 1).then(|| ("all".to_owned(), &summary.quality));
    summary.pieces.iter().map(|p| (p.name.clone(), &p.quality)).chain(all)
}

/// Distortion of the stand-in with the shortest cut and with the longer one.
fn bought(cut: &Cut) -> String {
    match (cut.distortion_shortest, cut.distortion) {
        (Some(shortest), Some(now)) if shortest != now => format!("{shortest:.3} -> {now:.3}"),
        (_, Some(now)) => format!("{now:.3}"),
        _ => NOTHING.to_owned(),
    }
}

fn more(quality: &Quality, name: &str) -> Option<f64> {
    quality.more.get(name)?.as_f64()
}

fn distortion(summary: &Summary) -> Table {
    let headings =
        ["<piece", "stretch L2", "largest", "Dirichlet", "flips", "springs", "p99/p1", "angle", "mass p99/p1"];
    let mut table = Table::new(&headings);
    let number = |x| significant(x, 4);
    for (name, q) in qualities(summary) {
        table.row([
            name,
            or_dash(q.stretch_l2, number),
            or_dash(q.stretch_max, number),
            or_dash(q.symmetric_dirichlet, number),
            or_dash(q.flips, grouped),
            or_dash(q.spring_anisotropy, number),
            or_dash(more(q, "spring_p99_to_p1"), number),
            or_dash(more(q, "spring_angle_degrees"), |x| format!("{}°", significant(x, 3))),
            or_dash(more(q, "mass_p99_to_p1"), number),
        ]);
    }
    table
}

fn fidelity(summary: &Summary) -> Table {
    let mut table = Table::new(&["<piece", "PSNR", "RMS", "", "Hausdorff", "", "normals", "folded area"]);
    for (name, q) in qualities(summary) {
        table.row([
            name,
            or_dash(q.psnr, |x| format!("{} dB", significant(x, 4))),
            or_dash(q.rms, length),
            or_dash(q.rms_rel, percent),
            or_dash(q.hausdorff, length),
            or_dash(q.hausdorff_rel, percent),
            or_dash(q.normal_degrees, |x| format!("{}°", significant(x, 3))),
            or_dash(q.fold_area, percent),
        ]);
    }
    table
}

fn maps(summary: &Summary) -> Table {
    let mut table = Table::new(&["<piece", "<map", "<file", "size"]);
    for p in &summary.pieces {
        for m in &p.maps {
            table.row([p.name.clone(), m.map.clone(), m.file.clone(), or_dash(m.bytes, bytes)]);
        }
    }
    table
}

fn accessories(out: &Output, summary: &Summary) -> (String, String) {
    let all = &summary.accessories;
    let shown = if out.verbose { all.len() } else { all.len().min(SOME) };
    let heading = match all.len() - shown {
        0 => format!("Accessories ({})", all.len()),
        _ => format!("Accessories ({}, the first {shown}; -v for all)", all.len()),
    };
    let mut table = Table::new(&["<accessory", "triangles", "area", "<rides on", "u", "v", "offset", "<reason"]);
    for a in &all[..shown] {
        let piece = summary.pieces.get(a.piece as usize);
        table.row([
            a.name.clone(),
            grouped(a.triangles.into()),
            area(a.area),
            or_dash(piece, |p| p.name.clone()),
            significant(a.u, 3),
            significant(a.v, 3),
            length(a.normal_offset),
            a.reason.clone(),
        ]);
    }
    (heading, table.render())
}

fn repairs(repairs: &[Repair]) -> String {
    let mut table = Table::new(&["<", "<", "<", "", "<"]);
    for r in repairs {
        let count = units::times(r.count, &r.message).unwrap_or_default();
        let example = r.examples.first().map(|e| format!(" ({e})")).unwrap_or_default();
        table.row([r.severity.clone(), r.stage.clone(), r.kind.clone(), count, format!("{}{example}", r.message)]);
    }
    table.render()
}

fn options(summary: &Summary) -> Table {
    let mut table = Table::new(&["<", "<"]);
    for (name, value) in &summary.options {
        let text = match value {
            Value::String(text) => text.clone(),
            Value::Null => NOTHING.into(),
            Value::Array(items) if items.is_empty() => NOTHING.into(),
            other => other.to_string(),
        };
        table.row([name.clone(), text]);
    }
    table
}

/// The times of a build.
pub fn times(out: &Output, stages: &[Stage], seconds: f64, peak_bytes: Option<u64>) -> String {
    let mut table = Table::new(&["<stage", "time", "peak memory"]);
    for s in stages {
        table.row([s.stage.clone(), time(s.seconds), or_dash(s.peak_bytes, bytes)]);
    }
    table.row(["all".into(), time(seconds), or_dash(peak_bytes, bytes)]);
    section(out, "Times", &table.render())
}
