//! `gimage inspect`: what is in a bundle, and how good it is.

mod picture;

use std::path::Path;

use gimage_runtime::Cloth;
use gimage_runtime::crossings::{self, Crossings, Drawn};
use serde::Serialize;

use crate::args::InspectArgs;
use crate::exit::{Exit, Failure};
use crate::files::{Pending, check_file_target};
use crate::output::{Output, Tone};
use crate::show;
use crate::summary::Summary;
use crate::timings::Timings;

#[derive(Serialize)]
struct Document<'a> {
    bundle: String,
    exit: u8,
    #[serde(flatten)]
    summary: &'a Summary,
    crossings: Crossed,
    #[serde(skip_serializing_if = "Option::is_none")]
    timings: Option<&'a Timings>,
}

/// The crossings of the cloth at rest.
#[derive(Serialize)]
struct Crossed {
    pairs: u64,
    touching: u64,
    deepest_m: f64,
    #[serde(skip_serializing_if = "Option::is_none")]
    picture: Option<String>,
}

/// Runs it.
pub fn run(args: &InspectArgs, out: &Output) -> Result<Exit, Failure> {
    let failed = |e| Failure::bundle(&args.bundle, &e);
    let bundle = gimage_bundle::dir::read_dir(&args.bundle).map_err(failed)?;
    let picture = args.picture.as_deref();
    picture.map(|path| check_picture(path, args.force)).transpose()?;
    let cloth = Cloth::from_bundle("cloth", &bundle)?;
    let found = crossings::find(&[Drawn::new(&cloth)], if picture.is_some() { usize::MAX } else { 0 })?;
    let summary = Summary::new(bundle).map_err(|f| Failure::refused(format!("{}: {f}", args.bundle.display())))?;
    let timings = Timings::of_bundle(&args.bundle);
    let exit = if summary.disagreements.is_empty() { Exit::Done } else { Exit::Findings };
    let path = args.bundle.display().to_string();
    // Written before the report, and in its place after it.
    let drawn = picture.map(|path| Pending::write(path, &picture::png_of(&cloth, &found)?)).transpose()?;
    if out.json {
        let crossings = Crossed {
            pairs: found.total(),
            touching: found.touching,
            deepest_m: found.deepest,
            picture: picture.map(|path| path.display().to_string()),
        };
        out.json(&Document {
            bundle: path,
            exit: exit.code(),
            summary: &summary,
            crossings,
            timings: timings.as_ref(),
        })?;
    } else {
        let mut text = show::overview(out, &path, &summary) + &show::details(out, &summary);
        text += &format!("\n{}\n  {}\n", out.heading("Crossings at rest"), words(&found));
        if let Some(t) = &timings {
            text += &show::times(out, &t.stages, t.seconds, t.peak_bytes);
        }
        out.data(&text)?;
    }
    if let Some((path, drawn)) = picture.zip(drawn) {
        drawn.commit()?;
        out.say(&format!("{}: {}", path.display(), words(&found)));
    }
    for sentence in &summary.disagreements {
        out.remark(Tone::Warning, "warning", sentence);
    }
    Ok(exit)
}

/// Refuses a picture that cannot be written, before any work.
fn check_picture(path: &Path, force: bool) -> Result<(), Failure> {
    if path.extension().is_none_or(|e| !e.eq_ignore_ascii_case("png")) {
        return Err(Failure::refused(format!("--picture {}: name a .png", path.display())));
    }
    check_file_target(path, force)
}

fn words(found: &Crossings) -> String {
    let touching = if found.touching > 0 { format!(", {} pairs touch", found.touching) } else { String::new() };
    match found.total() {
        0 => format!("no triangles cross{touching}"),
        1 => format!("1 pair of triangles crosses, {:.3} mm deep{touching}", 1e3 * found.deepest),
        pairs => format!("{pairs} pairs of triangles cross, up to {:.3} mm deep{touching}", 1e3 * found.deepest),
    }
}
