//! `gimage inspect`: what is in a bundle, and how good it is.

use serde::Serialize;

use crate::args::BundleArgs;
use crate::exit::{Exit, Failure};
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
    #[serde(skip_serializing_if = "Option::is_none")]
    timings: Option<&'a Timings>,
}

/// Runs it.
pub fn run(args: &BundleArgs, out: &Output) -> Result<Exit, Failure> {
    let failed = |e| Failure::bundle(&args.bundle, &e);
    let bundle = gimage_bundle::dir::read_dir(&args.bundle).map_err(failed)?;
    let summary = Summary::new(bundle).map_err(|f| Failure::refused(format!("{}: {f}", args.bundle.display())))?;
    let timings = Timings::of_bundle(&args.bundle);
    let exit = if summary.disagreements.is_empty() { Exit::Done } else { Exit::Findings };
    let path = args.bundle.display().to_string();
    if out.json {
        out.json(&Document { bundle: path, exit: exit.code(), summary: &summary, timings: timings.as_ref() })?;
    } else {
        let mut text = show::overview(out, &path, &summary) + &show::details(out, &summary);
        if let Some(t) = &timings {
            text += &show::times(out, &t.stages, t.seconds, t.peak_bytes);
        }
        out.data(&text)?;
    }
    for sentence in &summary.disagreements {
        out.remark(Tone::Warning, "warning", sentence);
    }
    Ok(exit)
}
