//! The drape test: a disk of each fabric hangs over a smaller plate, on three grids.

mod piece;
mod shadow;
mod table;

use gimage_bench_host::FRAME;
use gimage_runtime::{Backend, Material, Options, Reference, Scene, Solver, Stepper};

use crate::Failure;
use piece::{Piece, RIM};
use shadow::Shadow;

/// Cells from the plate to the rim, coarsest grid first.
const GRIDS: [u32; 3] = [6, 12, 24];
/// Starts of a fabric on a grid: the folds of a fabric lie anywhere, and another start leads to others.
const STARTS: u32 = 3;
/// Frames until the piece is at rest.
const FRAMES: u32 = 300;
/// Damping \[1/s\] instead of the fabric's own, which moves air and not the shape at rest.
const DAMPING: f32 = 4.0;
/// Steps per frame of the truth.
const TRUTH: u32 = 400;
/// Too few steps per frame for fabrics on a fine grid.
const FEW: u32 = 8;

/// The first line of the table.
pub const HEADER: &str = "fabric,around,along,solver,substeps,start,drape,folds,hem_mm,rest_mm_s";

/// A piece at rest.
#[derive(Clone, Debug)]
pub struct Rest {
    fabric: String,
    /// Cells around the rim and from the plate to the rim.
    cells: [u32; 2],
    solver: &'static str,
    substeps: u32,
    start: u32,
    /// Drape coefficient: the share of the free ring that the shadow covers.
    pub drape: f64,
    folds: usize,
    /// Mean height of the plate above the rim \[mm\].
    hem_mm: f64,
    /// RMS speed in the last step \[mm/s\].
    rest_mm_s: f64,
}

/// How a piece was draped.
struct Run {
    solver: &'static str,
    substeps: u32,
    /// Which start, as they differ by little.
    start: u32,
}

impl Rest {
    /// Its line of the table.
    pub fn line(&self) -> String {
        let Rest { fabric, cells: [around, along], solver, substeps, start, drape, folds, hem_mm, rest_mm_s } = self;
        format!("{fabric},{around},{along},{solver},{substeps},{start},{drape:.4},{folds},{hem_mm:.2},{rest_mm_s:.3}")
    }

    fn new(fabric: &str, piece: &Piece, run: Run, ends: [&[[f64; 4]]; 2]) -> Self {
        let (Run { solver, substeps, start }, [now, before]) = (run, ends);
        let free = Shadow::of(piece, &piece.flat()).area();
        let rim = piece.rim(now);
        let speed = |a: &[f64; 4], b: &[f64; 4]| (0..3).map(|c| (a[c] - b[c]).powi(2)).sum::<f64>();
        let mean = now.iter().zip(before).map(|(a, b)| speed(a, b)).sum::<f64>() / now.len() as f64;
        Rest {
            fabric: fabric.into(),
            cells: piece.cells(),
            solver,
            substeps,
            start,
            drape: Shadow::of(piece, now).area() / free,
            folds: folds(&rim.iter().map(|p| p[0].hypot(p[2])).collect::<Vec<_>>()),
            hem_mm: -1e3 * rim.iter().map(|p| p[1]).sum::<f64>() / rim.len() as f64,
            rest_mm_s: 1e3 * mean.sqrt() * f64::from(substeps) / FRAME,
        }
    }
}

/// Folds of a rim by its distances from the axis: how often it comes out past its middle by a tenth of its range.
fn folds(rim: &[f64]) -> usize {
    let (low, high) = rim.iter().fold((f64::INFINITY, 0.0), |(l, h), r| (f64::min(l, *r), f64::max(h, *r)));
    // Waves below a hundredth of the radius do not count.
    let band = (0.1 * (high - low)).max(0.005 * RIM);
    let middle = 0.5 * (low + high);
    let (mut out, mut count) = (None, 0);
    // Twice around: the first round finds the side on which the second begins.
    for (k, r) in rim.iter().chain(rim).enumerate() {
        let side = if *r > middle + band {
            Some(true)
        } else if *r < middle - band {
            Some(false)
        } else {
            out
        };
        count += usize::from(k >= rim.len() && out == Some(false) && side == Some(true));
        out = side;
    }
    count
}

/// A piece at rest under the default settings, or with a number of substeps.
fn settle(name: &str, (along, substeps): (u32, Option<u32>), start: u32) -> Result<Rest, Failure> {
    let fabric = &fabric(name)?;
    let piece = Piece::new(along, start, fabric, DAMPING)?;
    let options = Options { backend: Backend::Cpu, threads: 1, normals: false, substeps, ..Options::default() };
    let mut stepper = Stepper::new(scene(&piece), options, None)?;
    for _ in 0..FRAMES {
        stepper.advance(FRAME)?;
    }
    let wide = |list: Option<&[[f32; 4]]>| -> Vec<[f64; 4]> {
        list.unwrap_or_default().iter().map(|p| p.map(f64::from)).collect()
    };
    let (now, before) = (wide(stepper.positions(0)), wide(stepper.previous(0)));
    let solver = if substeps.is_some() { "given" } else { "default" };
    Ok(Rest::new(name, &piece, Run { solver, substeps: stepper.substeps(), start }, [&now, &before]))
}

/// The same in f64 and in many steps.
fn truth(name: &str, along: u32, start: u32) -> Result<Rest, Failure> {
    let fabric = &fabric(name)?;
    let piece = Piece::new(along, start, fabric, DAMPING)?;
    let options =
        Options { solver: Solver::Xpbd, tethers: 0, substeps: Some(TRUTH), normals: false, ..Options::default() };
    let mut reference = Reference::new(scene(&piece), options)?;
    (0..FRAMES).for_each(|_| reference.step(TRUTH));
    let (now, before) = reference.positions(0)?;
    Ok(Rest::new(name, &piece, Run { solver: "truth-f64", substeps: TRUTH, start }, [now, before]))
}

fn scene(piece: &Piece) -> Scene {
    let mut scene = Scene::new("drape");
    scene.cloths.push(piece.cloth.clone());
    scene
}

fn fabric(name: &str) -> Result<Material, Failure> {
    Material::named(name).ok_or_else(|| format!("no fabric has the name {name}").into())
}

/// Every fabric that is asked for by name (all if none is), grid and start, under the defaults and by the twin or with a number
/// of substeps; starts run at the same time.
pub fn all(asked: &[String], given: Option<u32>) -> Result<Vec<Rest>, Failure> {
    let mut rests = Vec::new();
    let is_asked = |name: &str| asked.iter().any(|a| a == name);
    let any = Material::names().any(is_asked);
    for name in Material::names().filter(|name| !any || is_asked(name)) {
        let one = |start| every(name, given, start).map_err(|error| error.to_string());
        let some = std::thread::scope(|scope| {
            let threads: Vec<_> = (0..STARTS).map(|start| scope.spawn(move || one(start))).collect();
            threads.into_iter().map(|t| t.join().map_err(|_| "a run panicked".to_owned())?).collect::<Vec<_>>()
        });
        for rest in some {
            rests.extend(rest?);
        }
        eprint!("{}", table::markdown(&rests));
    }
    Ok(rests)
}

/// A number of substeps on all grids; or the truth on the coarsest grid, the defaults on all, and a few substeps on the finest.
fn every(name: &str, given: Option<u32>, start: u32) -> Result<Vec<Rest>, Failure> {
    if given.is_some() {
        return GRIDS.into_iter().map(|along| settle(name, (along, given), start)).collect();
    }
    let mut rests = vec![truth(name, GRIDS[0], start)?];
    for along in GRIDS {
        rests.push(settle(name, (along, None), start)?);
    }
    rests.push(settle(name, (GRIDS[2], Some(FEW)), start)?);
    Ok(rests)
}

#[cfg(test)]
#[path = "drape/tests.rs"]
mod tests;
