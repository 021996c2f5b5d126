//! `fidelity`: what a build costs against how faithful its images are, for every mesh and setting, beside the peers.
//!
//! Each timed build runs in a child process of its own (`fidelity one`), so that CPU time and peak memory are that
//! build's alone. Quality is measured afterwards, in builds that are not timed.

mod args;
mod bench;
mod clock;
mod job;
mod machine;
mod measured;
mod one;
mod peer;
mod plot;
mod quality;
mod row;
mod source;

use std::process::ExitCode;

use clap::Parser;

use args::{Cli, Command};

/// Whatever went wrong, in words.
type Failure = Box<dyn std::error::Error + Send + Sync>;

fn main() -> ExitCode {
    let cli = Cli::parse();
    let result = match &cli.command {
        Some(Command::One(args)) => one::run(args),
        Some(Command::Plot(args)) => plot::run(args),
        None => bench::run(&cli.bench),
    };
    match result {
        Ok(()) => ExitCode::SUCCESS,
        Err(failure) => {
            eprintln!("error: {failure}");
            ExitCode::FAILURE
        }
    }
}
