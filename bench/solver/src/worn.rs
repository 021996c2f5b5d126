//! Garments as people wear them: time and stretch of the defaults and of settings by hand, normals included.

mod score;
mod truth;

use std::path::Path;

use gimage::options::{BuildOptions, ImageSize};
use gimage_bench_host::{FRAME, Gpu, Host};
use gimage_runtime::scene::file::{Found, SceneFile, Source};
use gimage_runtime::{Backend, Options};

use crate::Failure;
use score::Worst;
pub use truth::lines as truths;

/// Scenes of `bench/solver/scenes`.
const WORN: [&str; 4] = ["g1_arms", "g1_shoulders", "cape", "dress"];
/// Substeps and rounds of polish by hand; none are the defaults.
const SETTINGS: [Option<(u32, u32)>; 13] = [
    None,
    Some((8, 0)),
    Some((16, 0)),
    Some((32, 0)),
    Some((64, 0)),
    Some((8, 4)),
    Some((12, 4)),
    Some((16, 4)),
    Some((24, 4)),
    Some((8, 8)),
    Some((16, 8)),
    Some((24, 8)),
    Some((32, 8)),
];
/// First frame that is scored, and frames from one score to the next.
const SCORED: [u32; 2] = [60, 3];

/// The first line of the table.
pub const HEADER: &str = "scene,texels,substeps,polish,given,run,frames,ms_min,ms_median,extension_mean,extension_p99,\
                          extension_max,top_lowest_m,findings,truth_rms_mm";

/// The scenes that are asked for by name: all of them if none is.
pub fn scenes(asked: &[String]) -> Vec<&'static str> {
    let some: Vec<_> = WORN.into_iter().filter(|name| asked.iter().any(|a| a == name)).collect();
    if some.is_empty() { WORN.to_vec() } else { some }
}

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

/// A scene whose cloth starts a tenth of a millimetre beside that of the run before: such cloth is chaotic, and one run
/// proves little.
fn start(file: &SceneFile, run: u32) -> Result<gimage_runtime::Scene, Failure> {
    let mut scene = file.scene.clone();
    let cloth = scene.cloths.first_mut().ok_or("the scene has no cloth")?;
    let aside = 1e-4 * run as f32;
    cloth.place(cloth.positions().iter().map(|p| [p[0], p[1], p[2] + aside]).collect())?;
    Ok(scene)
}

/// Whether a frame is scored.
fn is_scored(frame: u32) -> bool {
    frame >= SCORED[0] && frame.is_multiple_of(SCORED[1])
}

/// A line of the table for each scene, setting and run. `truths` is a folder with what [`truths`] wrote.
pub fn lines(
    names: &[&str],
    texels: u32,
    runs: u32,
    truths: Option<&Path>,
    gpu: Option<&Gpu>,
) -> Result<Vec<String>, Failure> {
    let mut lines = Vec::new();
    for name in names {
        let file = load(name, texels)?;
        // Runs before settings, so that a busy minute of the machine is spread over all of these.
        for run in 0..runs {
            let truth = truths.map(|folder| truth::read(folder, name, texels, run)).transpose()?.flatten();
            for setting in SETTINGS {
                let line = line(&file, run, setting, truth.as_deref(), gpu)?;
                lines.push(format!("{name},{texels},{line}"));
            }
            eprintln!("{name}: run {run}");
        }
    }
    Ok(lines)
}

/// All of a line but the scene and its texels.
fn line(
    file: &SceneFile,
    run: u32,
    setting: Option<(u32, u32)>,
    truth: Option<&[[f64; 3]]>,
    gpu: Option<&Gpu>,
) -> Result<String, Failure> {
    let scene = start(file, run)?;
    let (substeps, polish) = setting.unzip();
    let backend = if gpu.is_some() { Backend::Gpu } else { Backend::Cpu };
    let options = Options { backend, threads: 1, substeps, polish, ..file.options.clone() };
    let frames = scene.frames;
    let mut host = Host::new(scene, options, gpu)?;
    let cloth = host.stepper.scene().cloths[0].clone();
    let (mut worst, mut times) = (Worst::default(), Vec::new());
    for frame in 1..=frames {
        file.script.frame(&mut host.stepper, f64::from(frame - 1) * FRAME, FRAME)?;
        times.push(host.timed(FRAME)?);
        if is_scored(frame) {
            worst.take(&cloth, &wide(&host.now()?));
        }
    }
    times.sort_by(f64::total_cmp);
    let choice = host.stepper.choice();
    let least = times.first().copied().unwrap_or(f64::NAN);
    let median = times.get(times.len() / 2).copied().unwrap_or(f64::NAN);
    let off = truth.map(|truth| Ok::<_, Failure>(truth::apart(truth, &wide(&host.now()?)))).transpose()?;
    Ok(format!(
        "{},{},{},{run},{frames},{least:.4},{median:.4},{},{},{}",
        choice.substeps,
        choice.polish,
        u8::from(setting.is_some()),
        worst.columns(),
        host.stepper.findings().len(),
        off.map(|mm| format!("{mm:.2}")).unwrap_or_default()
    ))
}

fn wide(positions: &[[f32; 4]]) -> Vec<[f64; 4]> {
    positions.iter().map(|p| p.map(f64::from)).collect()
}
