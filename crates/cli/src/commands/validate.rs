//! `gimage validate`: whether a bundle keeps the rules of its format.

use gimage_bundle::dir::validate_dir;
use gimage_bundle::{Fault, exit_code};
use serde_json::json;

use crate::args::BundleArgs;
use crate::exit::{Exit, Failure};
use crate::output::{Output, plain};

/// Runs it.
pub fn run(args: &BundleArgs, out: &Output) -> Result<Exit, Failure> {
    let (_, mut faults) = validate_dir(&args.bundle).map_err(|e| Failure::bundle(&args.bundle, &e))?;
    // An error of reading names its file once more in the message.
    for fault in &mut faults {
        if let Some(rest) = fault.message.strip_prefix(&format!("{}: ", fault.file)) {
            fault.message = rest.to_owned();
        }
    }
    let exit = match exit_code(&faults) {
        0 => Exit::Done,
        1 => Exit::Findings,
        _ => Exit::Refused,
    };
    let path = args.bundle.display().to_string();
    if out.json {
        out.json(&json!({"bundle": path, "exit": exit.code(), "sound": faults.is_empty(), "faults": faults}))?;
    } else {
        out.data(&lines(&faults))?;
    }
    match faults.len() {
        0 => out.say(&format!("{path}: sound")),
        1 => out.say(&format!("{path}: 1 finding")),
        n => out.say(&format!("{path}: {n} findings")),
    }
    Ok(exit)
}

fn lines(faults: &[Fault]) -> String {
    faults.iter().map(|fault| plain(&fault.to_string()).replace('\n', " ") + "\n").collect()
}
