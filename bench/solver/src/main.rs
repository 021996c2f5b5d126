//! Run time against error: each solver at several numbers of substeps on the built-in scenes.

mod chain;
mod drape;
mod garments;
mod plot;
mod reach;
mod row;
mod run;
mod score;
mod variant;
mod worn;

use std::fs;
use std::path::PathBuf;

use clap::Parser;
use gimage_bench_host::Gpu;
use gimage_runtime::scene::BUILTIN;
use row::Row;
use run::{Run, Setting};
use variant::{USUAL, Variant};

/// Anything that ends the program.
pub type Failure = Box<dyn std::error::Error>;

/// Milliseconds per frame and the error of each solver, on one thread of the CPU or on the GPU. CSV to stdout.
#[derive(Parser)]
#[command(after_help = "Examples:\n  solver --out solver.csv --svg solver.svg\n  \
                        solver --scenes s1 --particles 32 --solvers xpbd --substeps 4,8 --dump frames\n  \
                        solver --reach\n  solver --garments --substeps 8,16,32\n  solver --worn 4096 --truth truth --measure-truth --out truth.csv\n  \
                        solver --worn 4096 --truth truth --out worn.csv\n  solver --plot solver.csv,worn.csv --svg solver.svg\n  solver --drape --out drape.csv")]
struct Args {
    /// Built-in scenes, separated by commas.
    #[arg(long, value_delimiter = ',', default_values_t = BUILTIN.map(String::from))]
    scenes: Vec<String>,
    /// Particles along each side of the cloth.
    #[arg(long, value_delimiter = ',', default_value = "32,64,128,256")]
    particles: Vec<u32>,
    /// 512 particles along each side too.
    #[arg(long)]
    large: bool,
    /// Solvers by name: classic, or xpbd with any of +tethers2, +pyramid4 and +polish1.
    #[arg(long, value_delimiter = ',', default_values_t = USUAL.map(String::from))]
    solvers: Vec<String>,
    /// Steps per frame.
    #[arg(long, value_delimiter = ',', default_value = "1,2,3,4,6,8,12,16,32")]
    substeps: Vec<u32>,
    /// The settings that are meant to reach what the solver should, the classic solver in 16 steps beside them; a table of
    /// them and of what they are held against to stdout.
    #[arg(long)]
    reach: bool,
    /// The garments of this many texels on their bodies, as in `assets/scenes`, instead of the built-in scenes.
    #[arg(long, value_name = "TEXELS", num_args = 0..=1, default_missing_value = "4096", value_parser = clap::value_parser!(u32).range(64..=1 << 20))]
    garments: Option<u32>,
    /// Garments of this many texels as people wear them (`bench/solver/scenes`, `--scenes` for some of them): the defaults and
    /// settings by hand, with normals; a table of its own instead of the built-in scenes.
    #[arg(long, value_name = "TEXELS", num_args = 0..=1, default_missing_value = "4096", value_parser = clap::value_parser!(u32).range(64..=1 << 20))]
    worn: Option<u32>,
    /// Runs of each setting of `--worn`.
    #[arg(long, default_value_t = 3)]
    runs: u32,
    /// A folder of the last frames of `--worn` by the twin in f64 at 1,000 steps per frame: the table has distances from them.
    #[arg(long, value_name = "FOLDER")]
    truth: Option<PathBuf>,
    /// Computes what the folder of `--truth` lacks, instead of measuring; a table of how far the twin stretches.
    #[arg(long, requires = "truth")]
    measure_truth: bool,
    /// The drape test: a disk of each fabric on a plate, on three grids, under the defaults and by the twin in f64, or with this
    /// number of substeps (`--scenes` for some fabrics); a table of its own instead of the built-in scenes, and means to stderr.
    #[arg(long, value_name = "SUBSTEPS", num_args = 0..=1)]
    drape: Option<Option<u32>>,
    /// A first look: 32 and 64 particles, 2, 8 and 16 steps.
    #[arg(long)]
    quick: bool,
    /// Frames that are timed at least; short scenes are run again for it.
    #[arg(long, default_value_t = 120)]
    frames: u32,
    /// Parts of a scene in which its runs take turns, so that a busy minute of the machine is spread.
    #[arg(long, default_value_t = 10)]
    rounds: u32,
    /// On the GPU.
    #[arg(long)]
    gpu: bool,
    /// Writes the table to this file.
    #[arg(long)]
    out: Option<PathBuf>,
    /// Draws the tables of earlier runs, and of `bench/peers/cloth.csv`, in one plot.
    #[arg(long, value_delimiter = ',', value_name = "CSV")]
    plot: Vec<PathBuf>,
    /// Draws the plot to this file.
    #[arg(long)]
    svg: Option<PathBuf>,
    /// Writes the measured positions below this folder, a folder a run.
    #[arg(long)]
    dump: Option<PathBuf>,
}

fn main() -> Result<(), Failure> {
    let mut args = Args::parse();
    if args.quick {
        (args.particles, args.substeps) = (vec![32, 64], vec![2, 8, 16]);
    }
    if args.large {
        args.particles.push(512);
    }
    let variants = args.solvers.iter().map(|name| name.parse()).collect::<Result<Vec<Variant>, _>>()?;
    let gpu = if args.gpu { Some(Gpu::new()?) } else { None };
    eprintln!("on {}", gpu.as_ref().map_or("one thread of the CPU", |g| &g.info.name));
    if let Some(texels) = args.worn {
        let (scenes, truth) = (worn::scenes(&args.scenes), args.truth.as_deref());
        let lines = match truth {
            Some(folder) if args.measure_truth => worn::truths(&scenes, texels, args.runs, folder)?,
            _ => worn::lines(&scenes, texels, args.runs, truth, gpu.as_ref())?,
        };
        return args.table(worn::HEADER, lines);
    }
    if let Some(substeps) = args.drape {
        let rests = drape::all(&args.scenes, substeps)?;
        return args.table(drape::HEADER, rests.iter().map(drape::Rest::line));
    }
    if !args.plot.is_empty() {
        let tables = args.plot.iter().map(fs::read_to_string).collect::<Result<Vec<_>, _>>()?;
        let points = tables.iter().map(|table| plot::read(table)).collect::<Result<Vec<_>, _>>()?.concat();
        return match &args.svg {
            Some(path) => Ok(fs::write(path, plot::draw(&points))?),
            None => Err("--plot needs a file to draw to: --svg".into()),
        };
    }
    let mut rows = Vec::new();
    if args.reach {
        rows = reached(&args, gpu.as_ref())?;
    }
    if let Some(texels) = args.garments {
        rows.extend(garments::rows(&variants, &args.substeps, texels, gpu.as_ref())?);
    }
    for scene in args.scenes.iter().filter(|_| !args.reach && args.garments.is_none()) {
        for &n in &args.particles {
            let each = |v: &Variant| args.substeps.iter().map(|s| (v.clone(), *s)).collect::<Vec<_>>();
            let settings: Vec<_> = variants.iter().filter(|v| v.can(scene)).flat_map(each).collect();
            rows.extend(together(&args, &settings, scene, n, gpu.as_ref())?);
            eprintln!("{scene} {n}");
        }
    }
    let lines: Vec<String> = rows.iter().map(Row::line).collect();
    if let Some(path) = &args.svg {
        let table = [&[row::HEADER.to_owned()], &lines[..]].concat().join("\n");
        fs::write(path, plot::draw(&plot::read(&table)?))?;
    }
    if args.reach && args.out.is_none() { Ok(()) } else { args.table(row::HEADER, lines) }
}

impl Args {
    /// Writes a table to the file that is asked for, else to stdout.
    #[allow(clippy::print_stdout)]
    fn table(&self, header: &str, lines: impl IntoIterator<Item = String>) -> Result<(), Failure> {
        let table: String = std::iter::once(header.to_owned()).chain(lines).map(|line| line + "\n").collect();
        match &self.out {
            Some(path) => fs::write(path, table)?,
            None => print!("{table}"),
        }
        Ok(())
    }
}

/// The runs of [`reach::BARS`]; prints how they fare.
#[allow(clippy::print_stdout)]
fn reached(args: &Args, gpu: Option<&Gpu>) -> Result<Vec<Row>, Failure> {
    println!("{}", reach::HEADER);
    let mut rows = Vec::new();
    for bar in &reach::BARS {
        let classic: Variant = "classic".parse()?;
        let settings = [(classic, 16), (bar.solver.parse()?, bar.substeps)];
        let settings: Vec<_> = settings.into_iter().filter(|(v, _)| v.can(bar.scene)).collect();
        let some = together(args, &settings, bar.scene, bar.n, gpu)?;
        some.last().iter().for_each(|row| println!("{}", bar.line(row)));
        rows.extend(some);
    }
    Ok(rows)
}

/// All runs of a scene, in turns.
fn together(
    args: &Args,
    settings: &[(Variant, u32)],
    scene: &str,
    n: u32,
    gpu: Option<&Gpu>,
) -> Result<Vec<Row>, Failure> {
    let mut runs = Vec::new();
    for (variant, substeps) in settings {
        let setting = Setting { scene: scene.into(), n, variant: variant.clone(), substeps: *substeps };
        runs.push(Run::new(setting, gpu, args.dump.as_ref())?);
    }
    runs.retain(Run::is_as_asked);
    let length = runs.first().map_or(1, Run::length);
    let all = length * args.frames.div_ceil(length).max(1);
    let part = all.div_ceil(args.rounds.clamp(1, all));
    for first in (0..all).step_by(part as usize) {
        for run in &mut runs {
            run.go_on(part.min(all - first))?;
        }
    }
    Ok(runs.iter_mut().map(Run::row).collect())
}
