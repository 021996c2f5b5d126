//! Cloth under conditions that it should survive, under every solver.

mod case;
mod cases;
mod drive;
mod figures;
mod random;
mod table;

use std::path::PathBuf;
use std::process::ExitCode;

use case::SOLVERS;
use clap::Parser;
use drive::drive;
use table::Entry;

/// Tries cases on the CPU backend under every solver, and says which survive: table to stdout, exit status 1 if any
/// fails.
#[derive(Parser)]
#[command(after_help = "Examples:\n  stress --out stress.csv\n  stress --only \"mass ratio\" --solvers xpbd")]
struct Args {
    /// Only cases whose names have this in them.
    #[arg(long, default_value = "")]
    only: String,
    /// Solvers by name, separated by commas; all by default.
    #[arg(long, value_delimiter = ',')]
    solvers: Vec<String>,
    /// A million steps at rest instead of a hundred thousand.
    #[arg(long)]
    long: bool,
    /// Writes every figure to this file as CSV.
    #[arg(long)]
    out: Option<PathBuf>,
}

#[allow(clippy::print_stdout)]
fn main() -> Result<ExitCode, Box<dyn std::error::Error>> {
    let args = Args::parse();
    if let Some(name) = args.solvers.iter().find(|name| SOLVERS.iter().all(|s| s.0 != **name)) {
        return Err(format!("there is no solver {name}; there are {}", SOLVERS.map(|s| s.0).join(", ")).into());
    }
    let mut entries = Vec::new();
    for case in cases::all(if args.long { 1_000_000 } else { 100_000 })? {
        if !case.name.contains(&args.only) {
            continue;
        }
        let wanted = |name: &str| args.solvers.is_empty() || args.solvers.iter().any(|s| s == name);
        let outcomes = SOLVERS.map(|s| (wanted(s.0) && case.tries(s)).then(|| drive(&case, s)));
        let case::Case { name, step, substeps, asked, .. } = case;
        let entry = Entry { name, step, substeps, asked, outcomes };
        println!("{}", entry.line());
        entries.push(entry);
    }
    println!("{}", table::sum(&entries));
    if let Some(path) = &args.out {
        std::fs::write(path, table::csv(&entries))?;
    }
    let failed = entries.iter().flat_map(Entry::tried).any(|o| !o.failures.is_empty());
    Ok(if failed { ExitCode::FAILURE } else { ExitCode::SUCCESS })
}
