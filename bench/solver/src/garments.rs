//! Two garments on a body of colliders: how far each solver ends from the twin in f64 at a thousand steps per frame.

use std::path::Path;

use gimage::options::{BuildOptions, ImageSize};
use gimage_bench_host::{FRAME, Gpu, Host};
use gimage_runtime::scene::file::{Found, SceneFile, Source};
use gimage_runtime::{Backend, Options, Reference, Scene, Solver, measure};

use crate::Failure;
use crate::row::Row;
use crate::score::Figures;
use crate::variant::Variant;

/// Scenes of `assets/scenes`.
pub const GARMENTS: [&str; 2] = ["tshirt", "cape"];

/// Frames of a scene: four seconds, after which both hang still.
const FRAMES: u32 = 240;
/// Frames in which a run has its turn.
const TURN: u32 = 24;
/// Steps per frame of the truth, and of the run that tells how sure that is.
const TRUTH: [u32; 2] = [1000, 500];

/// Garments on the body, as pictures show them, in still air: wind keeps cloth from ending anywhere.
fn scene(name: &str, texels: u32) -> Result<Scene, Failure> {
    let folder = Path::new(env!("CARGO_MANIFEST_DIR")).join("../../assets/scenes");
    let find = |source: &Source| -> Found {
        let Source::Garment { file, .. } = source else { return Err(format!("{name}: no garment to build").into()) };
        let mut options = BuildOptions::default();
        options.image.size = ImageSize::Texels(texels);
        options.gate.metrics = false;
        let built = gimage::pipeline::build(&folder.join(file), &options, &gimage::progress::Quiet)?;
        Ok(built.bundle)
    };
    let bytes = std::fs::read(folder.join(format!("{name}.json")))?;
    let mut scene = SceneFile::parse(&bytes, find)?.scene;
    scene.wind = None;
    Ok(scene)
}

/// The last frame in f64, and one step before.
fn reference(scene: &Scene, options: &Options, substeps: u32) -> Result<Vec<[f64; 4]>, Failure> {
    let options = Options { solver: Solver::Xpbd, tethers: 0, pyramid: 0, substeps: Some(substeps), ..options.clone() };
    let mut reference = Reference::new(scene.clone(), options)?;
    (0..FRAMES).for_each(|_| reference.step(substeps));
    Ok(reference.positions(0)?.0.to_vec())
}

/// RMS distance \[mm\].
fn apart(a: &[[f64; 4]], b: &[[f64; 4]]) -> f64 {
    let square = |(p, q): (&[f64; 4], &[f64; 4])| (0..3).map(|c| (p[c] - q[c]).powi(2)).sum::<f64>();
    1e3 * (a.iter().zip(b).map(square).sum::<f64>() / a.len().max(1) as f64).sqrt()
}

/// A row for each solver and number of steps, all of a scene in turns, and one for half the steps of the truth.
pub fn rows(variants: &[Variant], substeps: &[u32], texels: u32, gpu: Option<&Gpu>) -> Result<Vec<Row>, Failure> {
    let backend = if gpu.is_some() { Backend::Gpu } else { Backend::Cpu };
    let base = Options { backend, threads: 1, normals: false, ..Options::default() };
    let mut rows = Vec::new();
    for name in GARMENTS {
        let scene = scene(name, texels)?;
        let cloth = scene.cloths.first().ok_or("the scene has no cloth")?.clone();
        let side = f64::from(texels).sqrt() as u32;
        let [truth, half] = [reference(&scene, &base, TRUTH[0])?, reference(&scene, &base, TRUTH[1])?];
        eprintln!("{name}: truth");
        let mut runs = Vec::new();
        for variant in variants {
            for &count in substeps {
                let host = Host::new(scene.clone(), variant.options(count, &base), gpu)?;
                runs.push((variant, count, host, Vec::new(), Vec::new()));
            }
        }
        for _ in 0..FRAMES / TURN {
            for (_, _, host, times, last) in &mut runs {
                for _ in 0..TURN {
                    *last = wide(&host.now()?);
                    times.push(host.timed(FRAME)?);
                }
            }
        }
        let row = |solver: &str, substeps, times: &[f64], end: &[[f64; 4]], before: &[[f64; 4]]| {
            let m = measure(&cloth, end, before, FRAME, scene.gravity);
            let figures = Figures {
                exploded: end.as_flattened().iter().any(|x| !x.is_finite()),
                stretch_max: Some(m.stretch_max),
                stretch_mean: Some(m.stretch_mean),
                position_rms_mm: Some(apart(end, &truth)),
                // The truth has no frame before its last.
                rest_mm_s: (!times.is_empty()).then(|| apart(end, before) / FRAME),
                ..Figures::default()
            };
            Row {
                scene: name.into(),
                n: side,
                solver: solver.into(),
                substeps,
                backend: if gpu.is_some() { "gpu" } else { "cpu" },
                frames: times.len(),
                ms_min: times.first().copied().unwrap_or(f64::NAN),
                ms_median: times.get(times.len() / 2).copied().unwrap_or(f64::NAN),
                figures,
            }
        };
        rows.push(row("truth-f64", TRUTH[0], &[], &truth, &truth));
        rows.push(row("truth-f64", TRUTH[1], &[], &half, &half));
        for (variant, count, host, mut times, last) in runs {
            times.sort_by(f64::total_cmp);
            rows.push(row(&variant.name, count, &times, &wide(&host.now()?), &last));
        }
        eprintln!("{name}");
    }
    Ok(rows)
}

fn wide(positions: &[[f32; 4]]) -> Vec<[f64; 4]> {
    positions.iter().map(|p| p.map(f64::from)).collect()
}
