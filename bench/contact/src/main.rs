//! `contact`: steps scenes in which cloth meets cloth, with contact and without, and counts crossings and milliseconds.

mod plot;
mod run;
mod scenes;

use std::fs;
use std::io::Write;
use std::path::PathBuf;
use std::process::ExitCode;

use clap::Parser;

use run::{Failure, Row, run};

/// Steps scenes in which cloth meets cloth, on one CPU core or on the GPU, and prints a CSV row per scene, size and setting.
#[derive(Debug, Parser)]
struct Cli {
    /// Scenes, or directories of bundles; all scenes by default.
    #[arg(value_name = "SCENE")]
    scenes: Vec<String>,
    /// Particles per side.
    #[arg(long, value_delimiter = ',', default_value = "64,128")]
    n: Vec<u32>,
    /// Scenes at the size that their sources give: particles per side and sheets; without SCENE those that have one.
    #[arg(long)]
    full: bool,
    /// Frames of 1/60 s; that of each scene by default.
    #[arg(long)]
    frames: Option<u32>,
    /// Count crossings in every K-th frame, 0 for never.
    #[arg(long, default_value_t = 10)]
    every: u32,
    /// Contact distances as multiples of the mean distance of neighbours; 0 is off.
    #[arg(long, value_delimiter = ',', default_value = "0,1")]
    distance: Vec<f32>,
    /// Tiers of contact.
    #[arg(long, value_enum, value_delimiter = ',', default_value = "particles")]
    tier: Vec<Tier>,
    /// Sheets of the scene `layers`.
    #[arg(long, default_value_t = 10)]
    layers: u32,
    /// Give each cloth of a scene a layer of its own, the first one the lowest.
    #[arg(long)]
    layered: bool,
    /// Print the crossings of every frame in which they are counted, to stderr.
    #[arg(long)]
    trace: bool,
    /// Step on the GPU. Times are those of a frame until its positions are read back.
    #[arg(long)]
    gpu: bool,
    /// Steps per frame; chosen by default.
    #[arg(long)]
    substeps: Option<u32>,
    /// Draws the tables of earlier runs in one plot, in place of a run.
    #[arg(long, value_delimiter = ',', value_name = "CSV", requires = "svg")]
    plot: Vec<PathBuf>,
    /// The file of the plot.
    #[arg(long, value_name = "FILE", requires = "plot")]
    svg: Option<PathBuf>,
}

/// The promise of contact.
#[derive(Clone, Copy, Debug, PartialEq, Eq, clap::ValueEnum)]
enum Tier {
    Particles,
    Safe,
}

fn main() -> ExitCode {
    let cli = Cli::parse();
    let done = match &cli.svg {
        Some(svg) => plot(&cli.plot, svg),
        None => table(&cli),
    };
    match done {
        Ok(()) => ExitCode::SUCCESS,
        Err(problem) => {
            eprintln!("error: {problem}");
            ExitCode::from(2)
        }
    }
}

/// Draws tables.
fn plot(tables: &[PathBuf], svg: &PathBuf) -> Result<(), Failure> {
    let read =
        |path: &PathBuf| plot::read(&fs::read_to_string(path)?).map_err(|e| format!("{}: {e}", path.display()).into());
    let points = tables.iter().map(read).collect::<Result<Vec<_>, Failure>>()?.concat();
    Ok(fs::write(svg, plot::draw(&points))?)
}

/// Writes the rows of all runs.
fn table(cli: &Cli) -> Result<(), Failure> {
    let mut out = std::io::stdout().lock();
    writeln!(out, "{}", Row::HEAD)?;
    for (name, size) in sizes(cli) {
        for distance in &cli.distance {
            // The tier is empty for runs without contact.
            let tiers = if *distance > 0.0 { &cli.tier[..] } else { &cli.tier[..1] };
            for tier in tiers {
                writeln!(out, "{}", run(cli, name, size, (*distance, *tier))?)?;
                out.flush()?;
            }
        }
    }
    Ok(())
}

/// Each scene with its sizes: particles per side, and sheets of a pile.
fn sizes(cli: &Cli) -> Vec<(&str, [u32; 2])> {
    let given = cli.scenes.iter().map(String::as_str);
    if cli.full {
        let asked = |name: &str| cli.scenes.is_empty() || cli.scenes.iter().any(|scene| scene == name);
        let full = scenes::FULL.iter().filter(|(name, ..)| asked(name));
        return full.map(|(name, n, layers)| (*name, [*n, *layers])).collect();
    }
    let names: Vec<&str> = if cli.scenes.is_empty() { scenes::NAMES.to_vec() } else { given.collect() };
    names.into_iter().flat_map(|name| cli.n.iter().map(move |n| (name, [*n, cli.layers]))).collect()
}
