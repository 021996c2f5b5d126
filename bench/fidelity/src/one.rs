//! The child: one build from file to bundle on disk, its cost on standard output as JSON.

use std::io::Write;
use std::time::Instant;

use gimage::pipeline::build;
use gimage::report::peak_memory;
use gimage_bundle::dir::write_files;
use serde::{Deserialize, Serialize};

use crate::Failure;
use crate::args::OneArgs;
use crate::clock::{Cost, StageClock, cpu_seconds};

/// The cost of a build.
#[derive(Clone, Debug, Default, PartialEq, Serialize, Deserialize)]
pub struct Run {
    /// Stages in order.
    pub stages: Vec<Cost>,
    /// From the start of the work to the bundle on disk \[s\].
    pub wall: f64,
    /// CPU time of the whole process, its start included \[s\].
    pub cpu: Option<f64>,
    /// Largest resident memory of the process \[bytes\].
    pub peak_bytes: Option<u64>,
}

/// Runs it.
pub fn run(args: &OneArgs) -> Result<(), Failure> {
    let (start, clock) = (Instant::now(), StageClock::new());
    let built = build(&args.mesh, &args.options(), &clock)?;
    // The pipeline's own last stage only counts; compressing goes on in it.
    let files = built.bundle.encode()?;
    clock.mark("write");
    write_files(&files, &args.out, true)?;
    let stages = clock.finish();
    let run = Run { stages, wall: start.elapsed().as_secs_f64(), cpu: cpu_seconds(), peak_bytes: peak_memory() };
    writeln!(std::io::stdout(), "{}", serde_json::to_string(&run)?)?;
    Ok(())
}
