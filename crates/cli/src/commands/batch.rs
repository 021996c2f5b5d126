//! Several garments in one run: a bad one fails by itself.

use std::collections::HashMap;
use std::fs;
use std::path::{Path, PathBuf};
use std::time::Instant;

use gimage_bundle::manifest::MANIFEST_FILE;
use serde::Serialize;

use crate::commands::build::{Job, Outcome, target};
use crate::exit::{Exit, Failure, guard};

#[derive(Serialize)]
#[serde(untagged)]
enum Entry {
    Built(Box<Outcome>),
    Failed { input: String, error: String, exit: u8 },
}

#[derive(Serialize)]
struct Document {
    exit: u8,
    builds: Vec<Entry>,
    seconds: f64,
    #[serde(skip_serializing_if = "Option::is_none")]
    peak_bytes: Option<u64>,
}

/// A directory that was made for a batch, and goes away again if nothing came into it.
struct Made<'a>(Option<&'a Path>);

impl Drop for Made<'_> {
    fn drop(&mut self) {
        if let Some(path) = self.0 {
            // Fails, as it should, if there is something in it.
            let _ = fs::remove_dir(path);
        }
    }
}

/// Builds all inputs, one after the other; the exit code is the worst.
pub fn run(job: &Job, inputs: &[PathBuf]) -> Result<Exit, Failure> {
    let start = Instant::now();
    let directory = job.args.output.as_path();
    let targets = targets(directory, inputs)?;
    let _made = prepare(directory)?;
    let (mut worst, mut builds, mut failed) = (Exit::Done, Vec::new(), Vec::new());
    for (input, output) in inputs.iter().zip(&targets) {
        let built = match guard(|| job.build(input, output)) {
            Ok((outcome, written)) => {
                if !job.out.json {
                    let gap = if builds.is_empty() { "" } else { "\n" };
                    job.out.data(gap)?;
                    job.show(&outcome)?;
                }
                written.commit().map(|()| outcome)
            }
            Err(failure) => Err(failure),
        };
        let exit = match built {
            Ok(outcome) => {
                let exit = job.told(&outcome);
                builds.push(Entry::Built(Box::new(outcome)));
                exit
            }
            Err(failure) => {
                job.out.error(&failure.message);
                let (input, exit) = (input.display().to_string(), failure.exit);
                failed.push(input.clone());
                builds.push(Entry::Failed { input, error: failure.message, exit: exit.code() });
                exit
            }
        };
        worst = worst.max(exit);
    }
    if !failed.is_empty() {
        job.out.error(&format!("{} of {} inputs failed: {}", failed.len(), inputs.len(), failed.join(", ")));
    }
    if job.out.json {
        let seconds = start.elapsed().as_secs_f64();
        let document = Document { exit: worst.code(), builds, seconds, peak_bytes: gimage::report::peak_memory() };
        job.out.json(&document).map_err(|failure| Failure {
            message: format!("{}; the bundles were written, but their report was not", failure.message),
            ..failure
        })?;
    }
    Ok(worst)
}

/// A bundle for each input, no two the same even where letter case does not count.
fn targets(directory: &Path, inputs: &[PathBuf]) -> Result<Vec<PathBuf>, Failure> {
    let mut seen: HashMap<String, &Path> = HashMap::new();
    let mut targets = Vec::new();
    for input in inputs {
        let path = target(directory, input);
        if let Some(other) = seen.insert(path.to_string_lossy().to_lowercase(), input) {
            let (a, b, path) = (other.display(), input.display(), path.display());
            return Err(Failure::refused(format!("{a} and {b} would both become {path}; build them one by one")));
        }
        targets.push(path);
    }
    Ok(targets)
}

fn prepare(directory: &Path) -> Result<Made<'_>, Failure> {
    if directory.join(MANIFEST_FILE).exists() {
        let problem = "it is a bundle itself, but several inputs need a directory for theirs; choose another output";
        return Err(Failure::refused(format!("{}: {problem}", directory.display())));
    }
    if directory.is_dir() {
        return Ok(Made(None));
    }
    fs::create_dir(directory).map_err(|e| {
        Failure::refused(format!("{}: {e}; several inputs need a directory for their bundles", directory.display()))
    })?;
    Ok(Made(Some(directory)))
}
