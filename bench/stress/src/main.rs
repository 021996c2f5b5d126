//! Cloth under conditions that it should survive, under every solver.

mod case;
mod cases;
mod contact;
mod crew;
mod drive;
mod figures;
mod heaps;
mod random;
mod scenes;
mod table;

use std::path::PathBuf;
use std::process::ExitCode;

use case::{Case, SOLVERS};
use clap::Parser;
use drive::drive;
use gimage_bench_host::Gpu;
use table::Entry;

/// Tries cases under every solver, on the CPU unless the GPU is asked for, and says which survive: table to stdout, exit status 1 if any
/// fails.
#[derive(Parser)]
#[command(
    after_help = "Examples:\n  stress --out stress.csv\n  stress --only \"mass ratio\" --solvers xpbd --gpu\n  stress --scenes 200 > random.csv\n  stress --contact --out contact.csv"
)]
struct Args {
    /// Only cases whose names have this in them.
    #[arg(long, default_value = "")]
    only: String,
    /// Solvers by name, separated by commas; all by default.
    #[arg(long, value_delimiter = ',')]
    solvers: Vec<String>,
    /// On the GPU.
    #[arg(long)]
    gpu: bool,
    /// A million steps at rest instead of a hundred thousand.
    #[arg(long)]
    long: bool,
    /// Instead of the cases: this many heaps of cloth, and how many are stretched by more than 5 % after 2 s, or not at rest
    /// after 15, in each number of `--substeps`.
    #[arg(long, value_name = "COUNT")]
    heaps: Option<usize>,
    /// Instead of the cases: this many random scenes under the default settings as CSV to stdout, and which of them stretch or
    /// pass a collider without a finding.
    #[arg(long, value_name = "COUNT", conflicts_with = "heaps")]
    scenes: Option<usize>,
    /// Instead of the cases: cloth that touches cloth under disturbances, in both tiers of contact on the CPU, with `--only`.
    #[arg(long, conflicts_with_all = ["heaps", "scenes", "gpu"])]
    contact: bool,
    /// Steps in 1/60 s of the heaps.
    #[arg(long, value_delimiter = ',', default_value = "8,16,24,32,48", requires = "heaps")]
    substeps: Vec<u32>,
    /// Threads, each with a cloth of its own; one a core by default. Figures do not depend on it.
    #[arg(long)]
    threads: Option<usize>,
    /// Writes every figure to this file as CSV.
    #[arg(long)]
    out: Option<PathBuf>,
}

#[allow(clippy::print_stdout)]
fn main() -> Result<ExitCode, Box<dyn std::error::Error>> {
    let args = Args::parse();
    if let Some(name) = args.solvers.iter().find(|name| SOLVERS.iter().all(|s| s.name != **name)) {
        return Err(format!("there is no solver {name}; the solvers are {}", SOLVERS.map(|s| s.name).join(", ")).into());
    }
    let threads = args.threads.unwrap_or_else(|| std::thread::available_parallelism().map_or(1, Into::into));
    if args.contact {
        let kept = contact::run(&args.only, threads, args.out.as_deref())?;
        return Ok(if kept { ExitCode::SUCCESS } else { ExitCode::FAILURE });
    }
    if let Some(count) = args.scenes {
        return Ok(if scenes::run(count, threads) { ExitCode::SUCCESS } else { ExitCode::FAILURE });
    }
    if let Some(count) = args.heaps {
        heaps::run(count, &args.substeps, threads);
        return Ok(ExitCode::SUCCESS);
    }
    let gpu = if args.gpu { Some(Gpu::new()?) } else { None };
    if let Some(gpu) = &gpu {
        eprintln!("on {}", gpu.info.name);
    }
    let steps = if args.long { 1_000_000 } else { 100_000 };
    let wanted = |name: &str| args.solvers.is_empty() || args.solvers.iter().any(|s| s == name);
    let names: Vec<_> = cases::all(steps)?.into_iter().map(|c| c.name).collect();
    let chosen: Vec<usize> = (0..names.len()).filter(|k| names[*k].contains(&args.only)).collect();
    // A case and solver a piece of work: cases differ in length by a factor of a hundred.
    let work = |cases: &gimage_runtime::Result<Vec<Case>>, n: usize| {
        let case = &cases.as_ref().ok()?[chosen[n / SOLVERS.len()]];
        let solver = SOLVERS[n % SOLVERS.len()];
        let outcome = (wanted(solver.name) && case.tries(solver) && !(args.gpu && case.cpu_only))
            .then(|| drive(case, solver, gpu.as_ref()));
        let Case { name, step, substeps, asked, .. } = case;
        Some((
            Entry { name: name.clone(), step: *step, substeps: *substeps, asked: *asked, outcomes: Vec::new() },
            outcome,
        ))
    };
    let mut entries: Vec<Entry> = Vec::new();
    crew::share(
        (chosen.len() * SOLVERS.len(), threads),
        || cases::all(steps),
        work,
        |result| {
            let Some((entry, outcome)) = result else { return };
            if entries.last().is_none_or(|e| e.outcomes.len() == SOLVERS.len()) {
                entries.push(entry);
            }
            let Some(entry) = entries.last_mut() else { return };
            entry.outcomes.push(outcome);
            if entry.outcomes.len() == SOLVERS.len() {
                println!("{}", entry.line());
            }
        },
    );
    println!("{}", table::sum(&entries));
    if let Some(path) = &args.out {
        std::fs::write(path, table::csv(&entries))?;
    }
    let failed = entries.iter().flat_map(Entry::tried).any(|o| !o.failures.is_empty());
    Ok(if failed { ExitCode::FAILURE } else { ExitCode::SUCCESS })
}
