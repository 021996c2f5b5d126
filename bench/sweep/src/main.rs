//! `sweep`: builds every mesh of a folder, generated hard meshes and damaged garments, each in a child process, and
//! checks what came out against what went in.

mod args;
mod budgets;
mod child;
mod damage;
mod garments;
mod hard;
mod jobs;
mod launch;
mod limit;
mod probe;
mod random;
mod record;
mod shape;
mod table;
mod verdict;

use std::process::ExitCode;

use clap::Parser;

use args::{Cli, Command};

/// Whatever went wrong, in words.
type Failure = Box<dyn std::error::Error + Send + Sync>;

fn main() -> ExitCode {
    let cli = Cli::parse();
    let result = match &cli.command {
        Some(Command::One(args)) => child::run(args).map(|()| true),
        None => jobs::run(&cli.sweep),
    };
    match result {
        Ok(true) => ExitCode::SUCCESS,
        Ok(false) => ExitCode::from(1),
        Err(failure) => {
            eprintln!("error: {failure}");
            ExitCode::from(2)
        }
    }
}
