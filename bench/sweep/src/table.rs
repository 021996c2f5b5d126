//! The summary of a sweep on standard output, and its rows as CSV.

use std::collections::BTreeMap;
use std::fmt::Write;

use crate::record::{Piece, Record, Rung, Status};
use crate::verdict::{Grade, HAUSDORFF, OUTSIDE, POOR_DB, REQUIREMENTS, WRECK_DB, grade, violations, warned};

/// Width of a bar of the histogram in characters.
const BAR: usize = 50;

/// The tables of a sweep, and whether every requirement holds.
pub fn summary(records: &[Record], limit_seconds: f64, worst: usize) -> (String, bool) {
    let mut out = String::new();
    let built = records.iter().filter(|r| r.status == Status::Built).count();
    let pieces: Vec<(&Record, &Piece)> = records.iter().flat_map(|r| r.pieces.iter().map(move |p| (r, p))).collect();
    let clean = |r: &&Record| r.status == Status::Built && r.findings.iter().all(|f| f.severity == "note");
    let mut line = |text: String| {
        out += &text;
        out.push('\n');
    };
    line(format!(
        "{} builds: {built} built ({} without a finding), {} pieces",
        records.len(),
        records.iter().filter(clean).count(),
        pieces.len()
    ));
    let mut reasons: BTreeMap<String, usize> = BTreeMap::new();
    for r in records {
        let reason = match &r.status {
            Status::Built => continue,
            Status::Refused { kind, .. } => format!("refused: {kind}"),
            Status::Panicked(_) => "panicked".into(),
            Status::TimedOut => "timed out".into(),
            Status::Died => "ended by the system".into(),
        };
        *reasons.entry(reason).or_default() += 1;
    }
    reasons.iter().for_each(|(reason, n)| line(format!("  {n:5}  {reason}")));
    let seconds = records.iter().map(|r| r.cpu).fold(0.0, f64::max);
    let mib = records.iter().map(|r| r.mib).fold(0.0, f64::max);
    line(format!(
        "CPU time {:.0} s, longest {seconds:.1} s; largest memory {mib:.0} MiB",
        records.iter().map(|r| r.cpu).sum::<f64>()
    ));
    line(String::new());
    line(format!("{:44} {:>8} {:>8}", "pieces", "warned", "silent"));
    let mut count = |name: String, test: &dyn Fn(&Piece) -> bool| {
        let found: Vec<bool> = pieces.iter().filter(|(_, p)| test(p)).map(|(r, p)| warned(r, p)).collect();
        let loud = found.iter().filter(|&&w| w).count();
        line(format!("{name:44} {loud:8} {:8}", found.len() - loud));
    };
    for limit in [WRECK_DB, POOR_DB] {
        count(format!("PSNR below {limit} dB"), &|p| p.worst_psnr().is_some_and(|x| x < limit));
    }
    for limit in HAUSDORFF {
        let name = format!("Hausdorff distance over {} % of the diagonal", 100.0 * limit);
        count(name, &|p| p.worst_hausdorff().is_some_and(|x| x > limit));
    }
    for limit in OUTSIDE {
        count(format!("outside the box by {} % of the diagonal", 100.0 * limit), &|p| p.probe.outside > limit);
    }
    count("measures of build and probe differ by 3 dB".into(), &|p| {
        // The build measures at most what f32 holds; above 45 dB a difference is one of samples.
        matches!((p.psnr, p.probe_psnr()), (Some(a), Some(b)) if (a - b).abs() > 3.0 && a.min(b) < POOR_DB)
    });
    out.push('\n');
    out += &kinds(records);
    out += &ladders(&pieces);
    out += &histogram(&pieces);
    out += &worst_list(&pieces, worst);
    let (text, sound) = requirements(records, limit_seconds);
    (out + &text, sound)
}

/// How many builds have a finding of each kind.
fn kinds(records: &[Record]) -> String {
    let mut found: BTreeMap<(String, String, String), usize> = BTreeMap::new();
    for f in records.iter().flat_map(|r| &r.findings).filter(|f| f.severity != "note") {
        *found.entry((f.severity.clone(), f.stage.clone(), f.kind.clone())).or_default() += 1;
    }
    let mut out = String::from("builds with findings\n");
    for ((severity, stage, kind), n) in found {
        let _ = writeln!(out, "  {n:5}  {severity:8} {stage}: {kind}");
    }
    out + "\n"
}

/// PSNR of the pieces in steps of 5 dB.
fn histogram(pieces: &[(&Record, &Piece)]) -> String {
    let step = |x: f64| ((x / 5.0).floor() * 5.0).clamp(-5.0, 120.0) as i32;
    let mut bins: BTreeMap<i32, usize> = BTreeMap::new();
    pieces.iter().filter_map(|(_, p)| p.worst_psnr()).for_each(|x| *bins.entry(step(x)).or_default() += 1);
    let most = bins.values().copied().max().unwrap_or(1);
    let mut out = String::from("pieces by PSNR, the worse of build and probe\n");
    for (&from, &n) in &bins {
        let name = if from < 0 { "     < 0 dB".to_owned() } else { format!("{from:4} .. {:3}", from + 5) };
        let _ = writeln!(out, "  {name:12} {n:6} {}", "#".repeat((n * BAR).div_ceil(most)));
    }
    out + "\n"
}

/// The worst pieces, then builds that made none.
fn worst_list(pieces: &[(&Record, &Piece)], worst: usize) -> String {
    let mut out = String::from("worst pieces\n");
    let mut sorted: Vec<_> = pieces.iter().filter(|(_, p)| grade(p) > Grade::Good).collect();
    let key = |p: &Piece| (grade(p), -p.worst_psnr().unwrap_or(f64::INFINITY));
    sorted.sort_by(|a, b| {
        let (a, b) = (key(a.1), key(b.1));
        b.0.cmp(&a.0).then(b.1.total_cmp(&a.1))
    });
    for (r, p) in sorted.iter().take(worst) {
        let word = if warned(r, p) { "warned" } else { "SILENT" };
        let figure = |x: Option<f64>| x.map_or_else(|| "-".into(), short);
        let _ = writeln!(
            out,
            "  {word} {} ({} texels, {}) {}: {} triangles, Euler {}, {} loops; PSNR {} dB, Hausdorff {}, outside {}, L2 {}",
            r.mesh,
            r.texels,
            r.sample,
            p.name,
            p.triangles,
            p.euler,
            p.loops,
            figure(p.worst_psnr()),
            figure(p.worst_hausdorff()),
            short(p.probe.outside),
            figure(p.l2)
        );
    }
    out + "\n"
}

/// A figure of three digits.
pub fn short(x: f64) -> String {
    if x == 0.0 || (1e-3..1e5).contains(&x.abs()) { format!("{x:.3}") } else { format!("{x:.2e}") }
}

/// The requirements, and how many builds violate each.
fn requirements(records: &[Record], limit_seconds: f64) -> (String, bool) {
    let mut out = String::from("requirements\n");
    let all: Vec<_> = records.iter().map(|r| violations(r, limit_seconds)).collect();
    let mut sound = true;
    for (k, name) in REQUIREMENTS.iter().enumerate() {
        let bad: Vec<&str> = records.iter().zip(&all).filter(|(_, v)| v[k]).map(|(r, _)| r.mesh.as_str()).collect();
        sound &= bad.is_empty();
        let some = bad.iter().take(6).copied().collect::<Vec<_>>().join(" ");
        let more = if bad.len() > 6 { " ..." } else { "" };
        let word = if bad.is_empty() { "holds" } else { "FAILS" };
        let _ = writeln!(out, "  {word}  {:5}  {name}  {some}{more}", bad.len());
    }
    (out, sound)
}

/// Columns of the CSV.
pub const COLUMNS: &str = "mesh,texels,sample,status,reason,file_triangles,cpu_s,wall_s,peak_mib,accessories,\
largest_accessory,warnings,repairs,piece,width,height,triangles,euler,loops,grade,warned,psnr_db,probe_psnr_out_db,\
probe_psnr_back_db,hausdorff_rel,probe_hausdorff_rel,outside_rel,l2_stretch,stretch_max,energy,normal_deg,fold_area,\
flips,rungs";

/// The rows of one build: one per piece, or one without a piece.
pub fn rows(r: &Record) -> Vec<String> {
    let (status, reason) = match &r.status {
        Status::Built => ("built", String::new()),
        Status::Refused { kind, message } => ("refused", format!("{kind}: {message}")),
        Status::Panicked(message) => ("panicked", message.clone()),
        Status::TimedOut => ("timed out", String::new()),
        Status::Died => ("ended", String::new()),
    };
    let kinds = |wanted: &[&str]| {
        let of = r.findings.iter().filter(|f| wanted.contains(&f.severity.as_str()));
        of.map(|f| format!("{} {}x", f.kind, f.count)).collect::<Vec<_>>().join("; ")
    };
    let head = [
        text(&r.mesh),
        r.texels.to_string(),
        r.sample.clone(),
        status.into(),
        text(&reason),
        r.triangles.to_string(),
        format!("{:.3}", r.cpu),
        format!("{:.3}", r.wall),
        format!("{:.0}", r.mib),
        r.accessories.to_string(),
        short(r.largest_accessory),
        text(&kinds(&["warning", "error"])),
        text(&kinds(&["repair"])),
    ]
    .join(",");
    if r.pieces.is_empty() {
        return vec![head + &",".repeat(COLUMNS.matches(',').count() - 12)];
    }
    let figure = |x: Option<f64>| x.map_or_else(String::new, |x| format!("{x:.6}"));
    let decibel = |rms: Option<f64>| figure(rms.map(|x| -20.0 * x.max(1e-9).log10()));
    let row = |p: &Piece| {
        [
            head.clone(),
            text(&p.name),
            p.width.to_string(),
            p.height.to_string(),
            p.triangles.to_string(),
            p.euler.to_string(),
            p.loops.to_string(),
            format!("{:?}", grade(p)).to_lowercase(),
            warned(r, p).to_string(),
            figure(p.psnr),
            decibel(p.probe.rms_out),
            decibel(p.probe.rms_back),
            figure(p.hausdorff),
            figure(p.probe.hausdorff),
            figure(Some(p.probe.outside)),
            figure(p.l2),
            figure(p.stretch),
            figure(p.energy),
            figure(p.normal),
            figure(p.fold),
            p.flips.map_or_else(String::new, |f| f.to_string()),
            text(&rungs(p)),
        ]
        .join(",")
    };
    r.pieces.iter().map(row).collect()
}

/// The rungs of a piece in order with their PSNR, the one that was kept with a star.
fn rungs(p: &Piece) -> String {
    let word = |r: &Rung| {
        let psnr = r.psnr.map_or_else(String::new, |x| format!(" {x:.1}"));
        format!("{}{psnr}{}", r.rung, if r.kept { "*" } else { "" })
    };
    p.rungs.iter().map(word).collect::<Vec<_>>().join(" ")
}

/// Pieces by the rung that was kept, with what it brought over the first one; nothing where no piece needed another.
fn ladders(pieces: &[(&Record, &Piece)]) -> String {
    let mut kept: BTreeMap<&str, Vec<f64>> = BTreeMap::new();
    for (_, p) in pieces {
        if let Some(r) = p.rungs.iter().find(|r| r.kept) {
            let first = p.rungs.first().and_then(|f| f.psnr);
            let gain = r.psnr.zip(first).map_or(f64::NAN, |(a, b)| a - b);
            kept.entry(&r.rung).or_default().push(gain);
        }
    }
    if kept.is_empty() {
        return String::new();
    }
    let mut out = String::from("pieces by the rung of the ladder that was kept, median gain over the first rung\n");
    for (rung, mut gains) in kept {
        gains.sort_by(f64::total_cmp);
        let middle = gains[gains.len() / 2];
        let gain = if middle.is_finite() { format!("{middle:+.1} dB") } else { "the first made none".into() };
        let _ = writeln!(out, "  {:5}  {rung}: {gain}", gains.len());
    }
    out + "\n"
}

/// A cell of text, quoted where it has to be.
fn text(s: &str) -> String {
    let s = s.replace(['\n', '\r'], " ");
    if s.contains([',', '"']) { format!("\"{}\"", s.replace('"', "\"\"")) } else { s }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn record(psnr: f64) -> Record {
        let piece = Piece { name: "a, b".into(), psnr: Some(psnr), ..Piece::default() };
        Record { mesh: "m".into(), status: Status::Built, pieces: vec![piece], ..Record::default() }
    }

    #[test]
    fn every_row_has_every_column() {
        let cells = |row: &str| {
            let quoted = row.split('"').enumerate().filter(|(k, _)| k % 2 == 1).map(|(_, s)| s.matches(',').count());
            row.matches(',').count() - quoted.sum::<usize>()
        };
        let refused = Status::Refused { kind: "piece: cut".into(), message: "no, \"never\"".into() };
        for r in [record(80.0), Record { status: refused, ..Record::default() }] {
            for row in rows(&r) {
                assert_eq!(cells(&row), cells(COLUMNS), "{row}");
            }
        }
    }

    #[test]
    fn rungs_are_counted_with_what_they_brought() {
        let mut r = record(78.0);
        let rung = |name: &str, psnr, kept| Rung { rung: name.into(), psnr, kept };
        r.pieces[0].rungs = vec![rung("first", Some(-15.0), false), rung("whole-mesh", Some(78.0), true)];
        assert!(rows(&r)[0].ends_with(",first -15.0 whole-mesh 78.0*"), "{}", rows(&r)[0]);
        assert!(summary(&[r], 60.0, 5).0.contains("1  whole-mesh: +93.0 dB"));
        assert!(!summary(&[record(78.0)], 60.0, 5).0.contains("rung"));
    }

    #[test]
    fn a_silent_wreck_fails_the_sweep_and_is_listed() {
        let (text, sound) = summary(&[record(80.0), record(12.0)], 60.0, 5);
        assert!(!sound && text.contains("SILENT m") && text.contains("FAILS"), "{text}");
        assert!(summary(&[record(80.0)], 60.0, 5).1);
        assert!(summary(&[], 60.0, 5).1);
    }
}
