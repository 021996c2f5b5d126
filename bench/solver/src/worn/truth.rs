//! The same garments by the twin in f64 at a thousand steps per frame.

use std::fs;
use std::path::{Path, PathBuf};

use gimage_bench_host::FRAME;
use gimage_runtime::{Options, Reference, Solver};

use super::score::Worst;
use super::{is_scored, load, start};
use crate::Failure;

/// Steps per frame.
const STEPS: u32 = 1000;

/// A line of the table for each scene and run whose last frame the folder lacks, which is written to it.
pub fn lines(names: &[&str], texels: u32, runs: u32, folder: &Path) -> Result<Vec<String>, Failure> {
    fs::create_dir_all(folder)?;
    let mut lines = Vec::new();
    for name in names {
        for run in 0..runs {
            let path = path(folder, name, texels, run);
            if path.exists() {
                continue;
            }
            let file = load(name, texels)?;
            let scene = start(&file, run)?;
            let (frames, cloth) = (scene.frames, scene.cloths.first().ok_or("the scene has no cloth")?.clone());
            let (substeps, polish) = (Some(STEPS), Some(0));
            let given = file.options.clone();
            let options =
                Options { solver: Solver::Xpbd, tethers: 0, pyramid: 0, substeps, polish, normals: false, ..given };
            let mut reference = Reference::new(scene, options)?;
            let mut worst = Worst::default();
            for frame in 1..=frames {
                let moved = file.script.moved(reference.colliders(), f64::from(frame - 1) * FRAME, FRAME);
                reference.set_colliders(moved)?;
                reference.step(STEPS);
                if is_scored(frame) {
                    worst.take(&cloth, reference.positions(0)?.0);
                }
            }
            let end = reference.positions(0)?.0;
            let bytes: Vec<u8> = end.iter().flat_map(|p| [p[0], p[1], p[2]]).flat_map(f64::to_le_bytes).collect();
            fs::write(path, bytes)?;
            lines.push(format!("{name},{texels},{STEPS},0,2,{run},{frames},,,{},,0", worst.columns()));
            eprintln!("{name}: truth {run}");
        }
    }
    Ok(lines)
}

fn path(folder: &Path, name: &str, texels: u32, run: u32) -> PathBuf {
    folder.join(format!("{name}-{texels}-{run}.f64"))
}

/// The last frame of a run, if the folder has it.
pub fn read(folder: &Path, name: &str, texels: u32, run: u32) -> Result<Option<Vec<[f64; 3]>>, Failure> {
    let path = path(folder, name, texels, run);
    if !path.exists() {
        return Ok(None);
    }
    let bytes = fs::read(path)?;
    let numbers: Vec<f64> =
        bytes.chunks_exact(8).map(|b| f64::from_le_bytes([b[0], b[1], b[2], b[3], b[4], b[5], b[6], b[7]])).collect();
    Ok(Some(numbers.chunks_exact(3).map(|p| [p[0], p[1], p[2]]).collect()))
}

/// RMS distance of the particles \[mm\].
pub fn apart(truth: &[[f64; 3]], now: &[[f64; 4]]) -> f64 {
    let square = |(a, b): (&[f64; 3], &[f64; 4])| (0..3).map(|c| (a[c] - b[c]).powi(2)).sum::<f64>();
    let real = || truth.iter().zip(now).filter(|(_, p)| p[3] >= 0.0);
    1e3 * (real().map(square).sum::<f64>() / real().count().max(1) as f64).sqrt()
}
