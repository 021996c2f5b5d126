//! Garments as people wear them: time and stretch of the defaults and of settings by hand, normals included.

use std::path::Path;

use gimage::options::{BuildOptions, ImageSize};
use gimage_bench_host::{FRAME, Gpu, Host};
use gimage_runtime::scene::file::{Found, SceneFile, Source};
use gimage_runtime::{Backend, Cloth, Options};

use crate::Failure;

/// Scenes of `bench/solver/scenes`.
const WORN: [&str; 4] = ["g1_arms", "g1_shoulders", "cape", "dress"];
/// Substeps and rounds of polish by hand; none are the defaults.
const SETTINGS: [Option<(u32, u32)>; 7] =
    [None, Some((8, 0)), Some((8, 8)), Some((12, 4)), Some((16, 8)), Some((24, 8)), Some((64, 0))];
/// First frame that is scored, and frames from one score to the next.
const SCORED: [u32; 2] = [60, 3];
/// Runs of a setting: such cloth is chaotic, and one run proves little. Each starts a tenth of a millimetre beside the last.
const RUNS: u32 = 3;

/// The first line of the table.
pub const HEADER: &str = "scene,texels,substeps,polish,given,run,frames,ms_min,ms_median,extension_mean,extension_p99,\
                          extension_max,top_lowest_m,findings";

fn load(name: &str, texels: u32) -> Result<SceneFile, Failure> {
    let folder = Path::new(env!("CARGO_MANIFEST_DIR")).join("scenes");
    let find = |source: &Source| -> Found {
        let Source::Garment { file, .. } = source else { return Err(format!("{name}: no garment to build").into()) };
        let mut options = BuildOptions::default();
        options.image.size = ImageSize::Texels(texels);
        options.gate.metrics = false;
        Ok(gimage::pipeline::build(&folder.join(file), &options, &gimage::progress::Quiet)?.bundle)
    };
    Ok(SceneFile::parse(&std::fs::read(folder.join(format!("{name}.json")))?, find)?)
}

/// Largest mean, 99th percentile and largest extension of the structural springs over the frames, and the lowest height
/// that the topmost particle had.
#[derive(Clone, Copy)]
struct Worst {
    extension: [f64; 3],
    top: f64,
}

fn score(cloth: &Cloth, now: &[[f32; 4]], worst: &mut Worst) {
    let mut all = Vec::new();
    for (g, grid) in cloth.grids().iter().enumerate() {
        let width = grid.width as usize;
        for (local, k) in grid.range().enumerate() {
            let inside = [local % width + 1 < width, local + width < grid.texels()];
            for (d, other) in [(0, k + 1), (1, k + width)] {
                let rest = match cloth.rest() {
                    gimage_runtime::Rest::None => 0.0,
                    gimage_runtime::Rest::Constant(r) => r[g][d],
                    gimage_runtime::Rest::Image(r) => r[k][d],
                };
                if inside[d] && rest > 0.0 {
                    let far = (0..3).map(|c| f64::from(now[k][c] - now[other][c]).powi(2)).sum::<f64>().sqrt();
                    all.push((far / f64::from(rest) - 1.0).max(0.0));
                }
            }
        }
    }
    all.sort_by(f64::total_cmp);
    let count = all.len().max(1);
    let at = |share: f64| all.get(((count - 1) as f64 * share) as usize).copied().unwrap_or(0.0);
    let figures = [all.iter().sum::<f64>() / count as f64, at(0.99), at(1.0)];
    worst.extension = [0, 1, 2].map(|k| worst.extension[k].max(figures[k]));
    let real = now.iter().filter(|p| p[3] >= 0.0);
    worst.top = worst.top.min(real.map(|p| f64::from(p[1])).fold(f64::NEG_INFINITY, f64::max));
}

/// A line of the table for each scene, setting and run.
pub fn lines(texels: u32, gpu: Option<&Gpu>) -> Result<Vec<String>, Failure> {
    let backend = if gpu.is_some() { Backend::Gpu } else { Backend::Cpu };
    let mut lines = Vec::new();
    for name in WORN {
        let file = load(name, texels)?;
        // Runs before settings, so that a busy minute of the machine is spread over all of these.
        for run in 0..RUNS {
            for setting in SETTINGS {
                let mut scene = file.scene.clone();
                let cloth = scene.cloths.first_mut().ok_or("the scene has no cloth")?;
                let aside = 1e-4 * run as f32;
                cloth.place(cloth.positions().iter().map(|p| [p[0], p[1], p[2] + aside]).collect())?;
                let (substeps, polish) = setting.unzip();
                let options = Options { backend, threads: 1, substeps, polish, ..file.options.clone() };
                let frames = scene.frames;
                let mut host = Host::new(scene, options, gpu)?;
                let cloth = host.stepper.scene().cloths[0].clone();
                let mut worst = Worst { extension: [0.0; 3], top: f64::INFINITY };
                let mut times = Vec::new();
                for frame in 1..=frames {
                    file.script.frame(&mut host.stepper, f64::from(frame - 1) * FRAME, FRAME)?;
                    times.push(host.timed(FRAME)?);
                    if frame >= SCORED[0] && frame.is_multiple_of(SCORED[1]) {
                        score(&cloth, &host.now()?, &mut worst);
                    }
                }
                times.sort_by(f64::total_cmp);
                let choice = host.stepper.choice();
                let [mean, p99, max] = worst.extension;
                let least = times.first().copied().unwrap_or(f64::NAN);
                let median = times.get(times.len() / 2).copied().unwrap_or(f64::NAN);
                lines.push(format!(
                    "{name},{texels},{},{},{},{run},{frames},{least:.4},{median:.4},{mean:.5},{p99:.5},{max:.5},{:.4},{}",
                    choice.substeps,
                    choice.polish,
                    u8::from(setting.is_some()),
                    worst.top,
                    host.stepper.findings().len()
                ));
            }
            eprintln!("{name}: run {run}");
        }
    }
    Ok(lines)
}
