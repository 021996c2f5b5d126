//! `gimage list`: the contents of a garment file, before it is built.

use gimage::contents::{ComponentEntry, Contents, Kind, Size, list};
use gimage::import::FileShape;
use gimage::record::Severity;
use gimage::select::Role;

use crate::args::ListArgs;
use crate::exit::{Exit, Failure};
use crate::output::{Output, Tone, plain};
use crate::table::{NOTHING, Table};
use crate::units::{grouped, length, significant};

/// Rows of a table without `--verbose`.
const ROWS: usize = 24;
/// Numbers of a component in a row.
const NUMBERS: usize = 3;

/// Runs it.
pub fn run(args: &ListArgs, out: &Output) -> Result<Exit, Failure> {
    let options = args.options();
    let contents = list(&args.input, &options).map_err(|e| Failure::of_input(&args.input, e))?;
    if out.json {
        out.json(&contents)?;
    } else {
        out.data(&text(out, &contents))?;
    }
    for finding in &contents.findings {
        let (tone, label) = match finding.severity {
            Severity::Note if finding.kind.starts_with("hint-") => (Tone::Note, "hint"),
            Severity::Warning if finding.kind == "no-cloth" => (Tone::Warning, "warning"),
            _ if out.verbose => (Tone::Note, "note"),
            _ => continue,
        };
        out.remark(tone, label, &format!("{}: {}: {}", contents.file, finding.kind, finding.message));
    }
    Ok(Exit::Done)
}

fn text(out: &Output, contents: &Contents) -> String {
    let size = &contents.size;
    let mut text = format!(
        "{}  {} triangles, {} vertices, {}, y {}\n",
        out.heading(&plain(&contents.file)),
        grouped(size.triangles as u64),
        grouped(size.vertices as u64),
        extent(size),
        heights([size.low[1], size.high[1]]),
    );
    text += &section(out, "Parts (--cloth, --body and --rigid choose by node, mesh or material)", parts(out, contents));
    text += &section(out, "Components (--cloth, --body and --rigid choose by component:K)", components(out, contents));
    text += &section(out, "Boundary loops (pin: K of --pin loop:K)", loops(out, contents));
    text += &section(out, "Skins", skins(contents));
    text += &section(out, "Animations", animations(out, contents));
    text + &section(out, "Colliders (--collider-source of dress and fit-colliders)", colliders(out, contents))
}

/// A heading and its table, with a line for the rows that are not shown; nothing without rows.
fn section(out: &Output, heading: &str, (table, more): (Table, Option<String>)) -> String {
    let body = table.render();
    if body.is_empty() && more.is_none() {
        return String::new();
    }
    let more = more.map(|m| format!("  {m}\n")).unwrap_or_default();
    format!("\n{}\n{body}{more}", out.heading(heading))
}

/// How many of `all` rows to show, and a line about the rest.
fn shown(out: &Output, all: usize, what: &str) -> (usize, Option<String>) {
    // A line that says "1 more" is as long as that row.
    if out.verbose || all <= ROWS + 1 {
        (all, None)
    } else {
        (ROWS, Some(format!("and {} more {what} (-v)", all - ROWS)))
    }
}

fn parts(out: &Output, contents: &Contents) -> (Table, Option<String>) {
    let mut table = Table::new(&[
        "<node",
        "<mesh",
        "<material",
        "copies",
        "triangles",
        "vertices",
        "<extent",
        "<y",
        "joints",
        "<build",
        "<why",
    ]);
    let (rows, more) = shown(out, contents.parts.len(), "parts");
    for p in &contents.parts[..rows] {
        let same = p.mesh == p.node;
        let why = match p.verdict.looks_like == p.verdict.role {
            true => p.verdict.reason.clone(),
            false => format!("looks like {}: {}", p.verdict.looks_like.name(), p.verdict.reason),
        };
        table.row([
            if p.node.is_empty() { NOTHING.into() } else { p.node.clone() },
            if same { String::new() } else { p.mesh.clone() },
            p.material.clone(),
            if p.copies == 1 { NOTHING.into() } else { p.copies.to_string() },
            grouped(p.size.triangles as u64),
            grouped(p.size.vertices as u64),
            extent(&p.size),
            heights([p.size.low[1], p.size.high[1]]),
            if p.joints == 0 { NOTHING.into() } else { p.joints.to_string() },
            use_of(p.verdict.role).into(),
            why,
        ]);
    }
    (table, more)
}

fn colliders(out: &Output, contents: &Contents) -> (Table, Option<String>) {
    let mut table = Table::new(&["<node", "<shape", "<from"]);
    let (rows, more) = shown(out, contents.colliders.len(), "colliders");
    for c in &contents.colliders[..rows] {
        let shape = match c.shape {
            FileShape::Sphere { .. } => "sphere",
            FileShape::Capsule { .. } => "capsule",
            FileShape::Cylinder { .. } => "cylinder",
            FileShape::Box { .. } => "box",
        };
        table.row([plain(&c.node), shape.into(), c.source.into()]);
    }
    (table, more)
}

/// The treatment of a part of this role by a build.
fn use_of(role: Role) -> &'static str {
    match role {
        Role::Cloth => "cloth",
        Role::Body => "left out: body",
        Role::Rigid => "left out: rigid",
        _ => "left out",
    }
}

fn components(out: &Output, contents: &Contents) -> (Table, Option<String>) {
    let mut table = Table::new(&[
        "<name",
        "<K",
        "<looks like",
        "thickness",
        "triangles",
        "vertices",
        "<extent",
        "<y",
        "loops",
        "<build",
    ]);
    // Crumbs are counted; there may be thousands.
    let (crumbs, large): (Vec<_>, Vec<_>) =
        contents.components.iter().partition(|c| c.kind == Kind::Crumb && !out.verbose);
    let (rows, mut more) = shown(out, large.len(), "components");
    for c in &large[..rows] {
        table.row([
            c.name.clone(),
            numbers(c),
            looks(c),
            c.thickness.map_or(NOTHING.into(), length),
            grouped(c.size.triangles as u64),
            grouped(c.size.vertices as u64),
            extent(&c.size),
            heights([c.size.low[1], c.size.high[1]]),
            if c.loops.is_empty() { NOTHING.into() } else { c.loops.len().to_string() },
            match (c.role, c.kind) {
                (Role::Cloth, Kind::Crumb | Kind::Overlay) => "accessory",
                (Role::Cloth, _) => "piece",
                (role, _) => use_of(role),
            }
            .into(),
        ]);
    }
    if !crumbs.is_empty() {
        let triangles: usize = crumbs.iter().map(|c| c.size.triangles).sum();
        let lines =
            [more.take(), Some(format!("{}, {} triangles (-v)", counted(crumbs.len()), grouped(triangles as u64)))];
        more = Some(lines.into_iter().flatten().collect::<Vec<_>>().join("\n  "));
    }
    (table, more)
}

fn counted(crumbs: usize) -> String {
    match crumbs {
        1 => "and 1 crumb".into(),
        n => format!("and {} crumbs", grouped(n as u64)),
    }
}

/// `3`, or `3, 5, 8 and 2 more` where repair joins components of the file.
fn numbers(c: &ComponentEntry) -> String {
    let shown = c.numbers.iter().take(NUMBERS).map(u32::to_string).collect::<Vec<_>>().join(", ");
    match c.numbers.len().saturating_sub(NUMBERS) {
        0 if shown.is_empty() => NOTHING.into(),
        0 => shown,
        more => format!("{shown} and {more} more"),
    }
}

fn looks(c: &ComponentEntry) -> String {
    match &c.other_sheet {
        Some(other) => format!("{} with {other}", c.kind.words()),
        None => c.kind.words().into(),
    }
}

fn loops(out: &Output, contents: &Contents) -> (Table, Option<String>) {
    let mut table = Table::new(&["<component", "loop", "pin", "edges", "length", "<y"]);
    let of = contents.components.iter().filter(|c| out.verbose || (c.kind != Kind::Crumb && c.role == Role::Cloth));
    let all: Vec<_> = of.flat_map(|c| c.loops.iter().enumerate().map(move |(k, l)| (c, k, l))).collect();
    let (rows, more) = shown(out, all.len(), "loops");
    for (c, k, l) in &all[..rows] {
        table.row([
            c.name.clone(),
            k.to_string(),
            l.pin.map_or(NOTHING.into(), |pin| pin.to_string()),
            grouped(l.edges as u64),
            length(l.length),
            heights(l.height),
        ]);
    }
    (table, more)
}

fn skins(contents: &Contents) -> (Table, Option<String>) {
    let mut table = Table::new(&["<skin", "joints"]);
    contents.skins.iter().for_each(|s| table.row([s.name.clone(), s.joints.to_string()]));
    (table, None)
}

fn animations(out: &Output, contents: &Contents) -> (Table, Option<String>) {
    let mut table = Table::new(&["<animation", "seconds"]);
    let (rows, more) = shown(out, contents.animations.len(), "animations");
    for a in &contents.animations[..rows] {
        table.row([a.name.clone(), a.seconds.map_or(NOTHING.into(), |s| significant(s, 3))]);
    }
    (table, more)
}

/// `1.06 x 0.62 x 0.38 m`, in the unit that suits the longest side.
fn extent(size: &Size) -> String {
    let sides = size.extent();
    let longest = sides.iter().copied().fold(0.0, f64::max);
    let (unit, name) = if longest >= 0.1 || longest == 0.0 { (1.0, "m") } else { (1e-3, "mm") };
    let side = |x: f64| if x < 1e-6 * longest { "0".into() } else { significant(x / unit, 3) };
    format!("{} x {} x {} {name}", side(sides[0]), side(sides[1]), side(sides[2]))
}

/// `0.8 to 1.4`, in metres.
fn heights([low, high]: [f64; 2]) -> String {
    let least = 1e-3 * low.abs().max(high.abs());
    let number = |x: f64| if x.abs() < least { "0".into() } else { significant(x, 3) };
    format!("{} to {} m", number(low), number(high))
}
