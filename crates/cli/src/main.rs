//! The `gimage` command: parsing, progress, printing and exit codes. The work is done by the library.

mod args;
mod commands;
mod exit;
mod files;
mod help;
mod output;
mod progress;
mod show;
mod summary;
mod table;
mod timings;
mod units;

use std::io::{ErrorKind, Write, stdout};
use std::path::Path;
use std::process::ExitCode;

use clap::Parser;

use args::{Cli, Command};
use exit::{Exit, Failure};
use output::Output;

fn main() -> ExitCode {
    exit::hush_panics();
    let cli = match Cli::try_parse() {
        Ok(cli) => cli,
        Err(error) => return usage(&error),
    };
    keep_freed_memory();
    let out = Output::new(cli.quiet, cli.verbose, cli.json());
    let result = exit::guard(|| match &cli.command {
        Command::Build(args) => commands::build::run(args, &out),
        Command::Dress(args) => commands::build::dress(args, &out),
        Command::List(args) => commands::list::run(args, &out),
        Command::Inspect(args) => commands::inspect::run(args, &out),
        Command::Validate(args) => commands::validate::run(args, &out),
        Command::Reconstruct(args) => commands::reconstruct::run(args, &out),
        Command::Simulate(args) => commands::simulate::run(args, &out),
        Command::Render(args) => commands::render::run(args, &out),
        Command::Export(args) => commands::export::run(args, &out),
        Command::FitColliders(args) => commands::fit_colliders::run(args, &out),
        Command::CheckCrossings(args) => commands::check_crossings::run(args, &out),
        Command::Doctor(args) => commands::doctor::run(args, &out),
    });
    let exit = result.unwrap_or_else(|failure| out.failure(&failure));
    ExitCode::from(exit.code())
}

/// Bytes of freed memory that stages hand on.
const HANDED_ON: usize = 8 << 20;

/// Lets stages reuse freed memory. Until a buffer of this size was freed, an allocator such as glibc's returns every large
/// buffer to the system, and each page of the next one is a fault again. The buffer is never touched.
fn keep_freed_memory() {
    drop(std::hint::black_box(Vec::<u8>::with_capacity(HANDED_ON)));
}

/// Help, the version, or what is wrong with the command line.
fn usage(error: &clap::Error) -> ExitCode {
    let printed = error.print().and_then(|()| stdout().flush());
    if error.exit_code() == 0 {
        // Help that cannot be written is a failure, unless its reader closed the pipe.
        return match printed {
            Err(e) if e.kind() != ErrorKind::BrokenPipe => {
                let failure = Failure::io(Path::new("stdout"), &e);
                ExitCode::from(Output::new(false, false, false).failure(&failure).code())
            }
            _ => ExitCode::SUCCESS,
        };
    }
    // The flags are not known, but who asks for JSON waits for JSON.
    if std::env::args_os().any(|arg| arg == "--json") {
        let text = error.render().to_string();
        let first = text.trim_start_matches("error: ").split("\n\n").next().unwrap_or_default();
        let message = first.split_whitespace().collect::<Vec<_>>().join(" ");
        let failure = Failure::refused(message);
        let _ = Output::new(true, false, true)
            .json(&serde_json::json!({"error": failure.message, "exit": failure.exit.code()}));
    }
    ExitCode::from(Exit::Refused.code())
}
