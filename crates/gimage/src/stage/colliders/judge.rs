//! How far the solids are from the body.

use gimage_bundle::Winding;
use rayon::prelude::*;
use serde::Serialize;

use super::fit::Placed;
use super::samples::{INSIDE, Sample};
use crate::base::closest::Closest;
use crate::base::mesh::Mesh;

/// Points along each axis of the box of a solid, for volumes, and pairs of points and triangles that are looked at, at most.
const CELLS: [f64; 2] = [4.0, 10.0];
const MAX_PAIRS: f64 = 4e8;

/// Distances between the common surface of solids and the body.
#[derive(Clone, Copy, Debug, Default, PartialEq, Serialize)]
pub struct FitError {
    /// Mean distance \[m\] of points of the body that can be touched.
    pub mean: f64,
    /// The distance that 95 % of them have at most.
    pub p95: f64,
    /// The largest.
    pub max: f64,
}

impl FitError {
    /// Of absolute distances; 0 without any.
    pub(super) fn of(distances: impl Iterator<Item = f64>) -> Self {
        let mut all: Vec<f64> = distances.map(f64::abs).collect();
        all.sort_by(f64::total_cmp);
        let at = |share: f64| all.get(((all.len() as f64 * share).ceil() as usize).max(1) - 1).copied().unwrap_or(0.0);
        FitError { mean: all.iter().sum::<f64>() / all.len().max(1) as f64, p95: at(0.95), max: at(1.0) }
    }
}

/// The figures of a fit.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct Figures {
    /// Points of the body to the common surface of all solids.
    pub body: FitError,
    /// The same for the points of each solid's own share of the body; for a guessed one of the clothes, before it was made narrower.
    pub of_each: Vec<FitError>,
    /// Volume \[m3\] of the solids that lies outside the body, overlaps counted once.
    pub outside: f64,
    /// The largest distance \[m\] of a point of that volume from the body.
    pub farthest: f64,
}

/// For each solid the distances of the samples that are nearest to it.
pub(super) fn each(placed: &[Placed], samples: &[Sample]) -> Vec<FitError> {
    let nearest = |s: &Sample| {
        let all = placed.iter().map(|p| p.solid.distance(s.point)).enumerate();
        all.min_by(|a, b| a.1.total_cmp(&b.1))
    };
    let of: Vec<(usize, f64)> = samples.iter().filter_map(nearest).collect();
    (0..placed.len()).map(|k| FitError::of(of.iter().filter(|n| n.0 == k).map(|n| n.1))).collect()
}

pub(super) fn judge(mesh: &Mesh, winding: &Winding, placed: &[Placed], samples: &[Sample]) -> Figures {
    let to_all = |s: &Sample| -> Vec<f64> { placed.iter().map(|p| p.solid.distance(s.point)).collect() };
    let nearest: Vec<(usize, f64)> = samples
        .par_iter()
        .filter_map(|s| {
            let all = to_all(s);
            let union = all.iter().copied().fold(f64::INFINITY, f64::min);
            let own = |k: &usize| placed[*k].joint == s.joint;
            let owner = (0..placed.len()).filter(own).min_by(|a, b| all[*a].total_cmp(&all[*b]));
            let any = || (0..placed.len()).min_by(|a, b| all[*a].total_cmp(&all[*b]));
            Some((owner.or_else(any)?, union))
        })
        .collect();
    let of = |k: usize| FitError::of(nearest.iter().filter(|n| n.0 == k).map(|n| n.1));
    let outside = outside(mesh, winding, placed);
    Figures {
        body: FitError::of(nearest.iter().map(|n| n.1)),
        of_each: (0..placed.len()).map(of).collect(),
        outside: outside.0,
        farthest: outside.1,
    }
}

/// The volume of the solids that lies outside the body, and its largest distance from it.
fn outside(mesh: &Mesh, winding: &Winding, placed: &[Placed]) -> (f64, f64) {
    let closest = Closest::new(&mesh.positions, &mesh.triangles);
    let pairs = (mesh.triangles.len() * placed.len()).max(1) as f64;
    let cells = (MAX_PAIRS / pairs).cbrt().clamp(CELLS[0], CELLS[1]) as usize;
    let of = |k: usize| {
        let solid = placed[k].solid;
        let (half, turn) = (solid.form.half_extents(), solid.turn());
        let (mut count, mut far) = (0usize, 0.0f64);
        for i in 0..cells.pow(3) {
            let cell = [i % cells, i / cells % cells, i / (cells * cells)];
            let local = [0, 1, 2].map(|k| (2.0 * (cell[k] as f64 + 0.5) / cells as f64 - 1.0) * half[k]);
            let p: [f64; 3] = (turn * nalgebra::Vector3::from(local) + nalgebra::Vector3::from(solid.center)).into();
            // The first solid that has a point counts it.
            if solid.form.distance(local.into()) > 0.0 || placed[..k].iter().any(|o| o.solid.distance(p) <= 0.0) {
                continue;
            }
            if winding.number(p) < INSIDE {
                count += 1;
                far = far.max(closest.project(p).map_or(0.0, |n| n.distance));
            }
        }
        let cell = 8.0 * half.iter().product::<f64>() / cells.pow(3) as f64;
        (count as f64 * cell, far)
    };
    let all: Vec<(f64, f64)> = (0..placed.len()).into_par_iter().map(of).collect();
    all.iter().fold((0.0, 0.0), |(sum, far), (v, f)| (sum + v, far.max(*f)))
}
