//! `gimage build`: a bundle from each garment file.

use std::path::{Path, PathBuf};
use std::time::Instant;

use gimage::colliders::ColliderOptions;
use gimage::options::BuildOptions;
use gimage::pipeline;
use gimage::record::{Finding, Severity};
use gimage::report::peak_memory;
use gimage_bundle::dir::{self, Staged};
use gimage_bundle::manifest::MANIFEST_FILE;
use gimage_bundle::{Bundle, Manifest};
use rayon::{ThreadPool, ThreadPoolBuilder};
use serde::Serialize;

use crate::args::{BuildArgs, DressArgs};
use crate::commands::batch;
use crate::exit::{Exit, Failure};
use crate::files::{Pending, check_parent};
use crate::output::{Output, Tone};
use crate::progress::Bar;
use crate::show;
use crate::summary::Summary;
use crate::timings::{self, Stage, Timings};
use crate::units::times;

/// The outcome of one input.
#[derive(Serialize)]
pub struct Outcome {
    input: String,
    output: String,
    /// The exit code it alone would give.
    exit: u8,
    #[serde(flatten)]
    summary: Summary,
    stages: Vec<Stage>,
    seconds: f64,
    #[serde(skip_serializing_if = "Option::is_none")]
    peak_bytes: Option<u64>,
    #[serde(skip)]
    findings: Vec<Finding>,
}

/// Everything that the inputs of a run share.
pub struct Job<'a> {
    pub args: &'a BuildArgs,
    options: BuildOptions,
    /// How solids are fitted to the body; none for a plain build.
    solids: Option<ColliderOptions>,
    pool: ThreadPool,
    pub out: &'a Output,
}

/// Runs it.
pub fn run(args: &BuildArgs, out: &Output) -> Result<Exit, Failure> {
    work(args, None, out)
}

/// Runs `gimage dress`.
pub fn dress(args: &DressArgs, out: &Output) -> Result<Exit, Failure> {
    work(&args.build, Some(args.colliders()), out)
}

fn work(args: &BuildArgs, solids: Option<ColliderOptions>, out: &Output) -> Result<Exit, Failure> {
    let options = args.options();
    options.check()?;
    solids.iter().try_for_each(ColliderOptions::check)?;
    // The main thread's stack is larger than a pool's by default; deep recursion in a decoder should not notice.
    let pool = ThreadPoolBuilder::new().num_threads(args.threads.into()).stack_size(8 << 20);
    let pool = pool.build().map_err(|e| Failure::refused(format!("option threads: {e}; request fewer")))?;
    let job = Job { args, options, solids, pool, out };
    match args.inputs.as_slice() {
        [input] => {
            let (outcome, written) = job.build(input, &args.output)?;
            // The report first: if nobody gets it, the build has failed, and a build that fails leaves nothing behind.
            if out.json {
                out.json(&outcome)?;
            } else {
                job.show(&outcome)?;
            }
            written.commit()?;
            Ok(job.told(&outcome))
        }
        inputs => batch::run(&job, inputs),
    }
}

/// A bundle and its times on the disk, beside their places.
pub struct Written {
    bundle: Staged,
    times: Option<Pending>,
}

impl Written {
    /// Puts them in their places: one rename each.
    pub fn commit(self) -> Result<(), Failure> {
        self.bundle.commit()?;
        self.times.map_or(Ok(()), Pending::commit)
    }
}

impl Job<'_> {
    /// Builds one bundle and writes all of it, to be committed.
    pub fn build(&self, input: &Path, output: &Path) -> Result<(Outcome, Written), Failure> {
        let start = Instant::now();
        check_parent(output)?;
        dir::check_target(output, self.args.force)?;
        if self.args.timings {
            timings::check_target(output)?;
        }
        let built = {
            let bar = Bar::new(self.out.bars(), &input.file_name().unwrap_or_default().to_string_lossy());
            self.pool
                .install(|| match &self.solids {
                    Some(solids) => pipeline::dress(input, &self.options, solids, &bar),
                    None => pipeline::build(input, &self.options, &bar),
                })
                .map_err(|e| Failure::of_input(input, e))?
        };
        let mut stages: Vec<Stage> = built.report.stages.iter().map(Stage::from).collect();
        let encoding = Instant::now();
        let files = self.pool.install(|| built.bundle.encode())?;
        let manifest = files.get(MANIFEST_FILE).ok_or_else(|| gimage::Error::Internal("no manifest".into()))?;
        add_time(&mut stages, ENCODE, encoding);
        // The manifest as written also names the files.
        let bundle = Bundle { manifest: Manifest::from_bytes(manifest)?, ..built.bundle };
        let summary = Summary::new(bundle)?;
        if let Some(disagreement) = summary.disagreements.first() {
            return Err(gimage::Error::Internal(disagreement.clone()).into());
        }
        let writing = Instant::now();
        // Staged before the bundle appears, so that no failure can leave one without the other.
        let times = (self.args.timings)
            .then(|| Timings::new(manifest, stages.clone(), start, self.pool.current_num_threads()).write(output))
            .transpose()?;
        let written = Written { bundle: Staged::write(&files, output, self.args.force)?, times };
        add_time(&mut stages, "write", writing);
        let exit = if built.report.has_findings() { Exit::Findings } else { Exit::Done };
        let outcome = Outcome {
            input: input.display().to_string(),
            output: output.display().to_string(),
            exit: exit.code(),
            summary,
            stages,
            seconds: start.elapsed().as_secs_f64(),
            peak_bytes: peak_memory(),
            findings: built.report.findings,
        };
        Ok((outcome, written))
    }

    /// The tables on stdout.
    pub fn show(&self, outcome: &Outcome) -> Result<(), Failure> {
        let mut text = show::overview(self.out, &outcome.output, &outcome.summary);
        if self.out.verbose {
            text += &show::details(self.out, &outcome.summary);
        }
        text += &show::times(self.out, &outcome.stages, outcome.seconds, outcome.peak_bytes);
        self.out.data(&text)
    }

    /// The words on stderr, and the exit code.
    pub fn told(&self, outcome: &Outcome) -> Exit {
        for finding in &outcome.findings {
            let (tone, label) = match finding.severity {
                // A note that asks to look again is for everyone, and so is one about parts that are not in the bundle.
                Severity::Note if finding.kind.starts_with("hint-") => (Tone::Note, "hint"),
                Severity::Note if finding.kind == "left-out" => (Tone::Note, "note"),
                Severity::Note if !self.out.verbose => continue,
                Severity::Note => (Tone::Note, "note"),
                Severity::Repair => (Tone::Warning, "repair"),
                Severity::Warning => (Tone::Warning, "warning"),
            };
            let example = finding.examples.first().map(|e| format!(" ({e})")).unwrap_or_default();
            let (input, kind) = (&outcome.input, finding.kind);
            let times = times(finding.count, &finding.message).map(|x| format!(", {x}")).unwrap_or_default();
            let text = format!("{input}: {kind}{times}: {}{example}", finding.message);
            self.out.remark(tone, label, &text);
        }
        self.out.say(&format!("wrote {}", outcome.output));
        if outcome.exit == 0 { Exit::Done } else { Exit::Findings }
    }
}

const ENCODE: &str = "encode";

/// Adds the time since `start` to the last stage if it has this name, else appends one.
fn add_time(stages: &mut Vec<Stage>, name: &str, start: Instant) {
    let (seconds, peak_bytes) = (start.elapsed().as_secs_f64(), peak_memory());
    match stages.last_mut().filter(|last| last.stage == name) {
        Some(last) => (last.seconds, last.peak_bytes) = (last.seconds + seconds, peak_bytes),
        None => stages.push(Stage { stage: name.into(), seconds, peak_bytes }),
    }
}

/// Where each input of a batch goes.
pub fn target(directory: &Path, input: &Path) -> PathBuf {
    let mut name = input.file_stem().unwrap_or_default().to_os_string();
    name.push(".gim");
    directory.join(name)
}
