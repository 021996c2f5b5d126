//! A map for every disk: the inside is simplified to one vertex, which any convex boundary can hold, and the vertices are put
//! back one at a time (progressive embedding: Shen, Jiang, Zorin, Panozzo 2019).
//!
//! A vertex comes back into the kernel of the polygon around it, which is never empty: seen from the vertex it had been
//! collapsed into, all of the polygon is in sight. In f64 that kernel may be too small to be found; energy keeps it
//! from becoming so. Unlike the paper, which smooths triangles towards equilateral ones where a split fails, every
//! vertex that comes back goes to the least energy of its own triangles, and whenever the inner vertices have doubled,
//! crushed triangles are spread and all vertices take Newton steps: each level starts near its minimum, so that areas
//! do not fall off exponentially into the arms of a disk as those of a convex combination map do.

use super::distortion::{Rest, energy, flips, planar, rest_shape, rest_shapes, signed_area2};
use super::local::{beside, room, settle, spread, turns, valid};
use super::newton::{self, NewtonOptions, NewtonRecord};
use super::system::System;
use super::{ParameterizeRecord, Shape, Way, distortion, tiles};
use crate::base::decimate::to_one;

/// Newton steps of a vertex that comes back.
const STEPS: usize = 2;
/// The steps of a level: the next one goes on from there.
const LEVEL: NewtonOptions = NewtonOptions { steps: 8, further: 200_000, tolerance: 1e-2 };
/// Spreading at a level: the energy that is low enough for Newton steps, and most turns.
const SPREAD: (f64, usize) = (1e4, 50);
/// Turns of all vertices at a level that is too fine for Newton steps.
const TURNS: usize = 2;
/// Largest energy of a disk of many triangles, in units of that of the finest level that took Newton steps: above it the whole
/// takes Newton steps too, tile by tile, of this much work in steps times triangles.
const WORSE: (f64, usize) = (1.05, 4_000_000);

/// As [`super::parameterize`], from one inner vertex on. Levels above 2 `enough` triangles take turns of single vertices
/// in place of Newton steps. `None` if two inner vertices are left that no collapse joins, as beside an inner edge
/// between boundary vertices; if two boundary vertices are in one place; or if f64 has no number left where a vertex must go.
/// O(n log n) and a few times the map of `enough` triangles.
pub(super) fn embed(
    shape: Shape<'_>,
    uv: &mut Vec<[f64; 2]>,
    options: &NewtonOptions,
    enough: usize,
) -> Option<ParameterizeRecord> {
    let Shape { positions, triangles, wanted, fixed } = shape;
    let mut now = to_one(positions, triangles, fixed);
    let mut inner = fixed.iter().map(|f| !f).collect::<Vec<bool>>();
    now.collapses.iter().for_each(|c| inner[c[0] as usize] = false);
    let mut left = inner.iter().filter(|x| **x).count();
    let all = left + now.collapses.len();
    let coarse = now.now();
    if let Some(v) = inner.iter().position(|x| *x) {
        uv[v] = room(v as u32, coarse.iter().filter(|t| t.contains(&(v as u32))).copied(), uv)?;
    }
    if left > 1 || flips(&coarse, uv) > 0 {
        return None;
    }
    let plane: f64 = coarse.iter().map(|&t| 0.5 * signed_area2(planar(uv, t))).sum();
    let mut scales = Scales::new(plane, shape, &coarse);
    let (mut level, mut last) = (left, f64::INFINITY);
    let mut fan: Vec<([u32; 3], Rest)> = Vec::new();
    for k in (0..now.collapses.len()).rev() {
        let [u, v] = now.collapses[k];
        fan.clear();
        now.undo(k, |t| {
            let mut rest = rest_shape(positions, t, wanted, scales.length);
            rest.weight = rest.weight.max(scales.least);
            fan.push((t, rest));
        });
        let corners = || fan.iter().map(|x| x.0);
        uv[u as usize] =
            room(u, corners(), uv).filter(|&p| valid(u, p, corners(), uv)).or_else(|| beside(u, v, corners(), uv))?;
        settle(u, fan.iter().map(|x| (x.0, &x.1)), uv, STEPS, true);
        left += 1;
        if left >= 2 * level && left < all {
            level = left;
            let there = now.now();
            scales = Scales::new(plane, shape, &there);
            let rest = rest_shapes(positions, &there, wanted, scales.length);
            let record = relax(&there, &rest, fixed, uv, &LEVEL, enough);
            last = if record.steps > 0 { record.end } else { last };
        }
    }
    drop(now);
    let rest = rest_shapes(positions, triangles, wanted, Scales::new(plane, shape, triangles).length);
    let mut newton = relax(triangles, &rest, fixed, uv, options, enough);
    if triangles.len() / 2 > enough && newton.end > WORSE.0 * last {
        let start = newton.start;
        newton = tiles::minimise(triangles, &rest, fixed, uv, (2 * enough, WORSE.1), options);
        newton.start = start;
    }
    let log_distortion = distortion::log_distortion(&rest, triangles, uv);
    (flips(triangles, uv) == 0).then_some(ParameterizeRecord {
        way: Way::Embedded,
        start_passes: 0,
        uniform_start: false,
        log_distortion,
        newton,
    })
}

/// Spreads crushed triangles, then takes Newton steps, or turns of single vertices if there are over 2 `enough` triangles.
fn relax(
    triangles: &[[u32; 3]],
    rest: &[Rest],
    fixed: &[bool],
    uv: &mut Vec<[f64; 2]>,
    options: &NewtonOptions,
    enough: usize,
) -> NewtonRecord {
    let (start, now) = spread(triangles, rest, fixed, uv, SPREAD);
    if triangles.len() / 2 <= enough {
        // Vertices that are still collapsed are in no triangle: they have no unknowns.
        let mut system = System::new(triangles, fixed);
        return NewtonRecord { start, ..newton::minimise(&mut system, rest, triangles, uv, options) };
    }
    turns(triangles, rest, fixed, uv, TURNS);
    let end = energy(rest, triangles, uv).min(now);
    NewtonRecord { steps: 0, start, end, converged: true, capped: false }
}

/// The measures of a level.
struct Scales {
    /// The length in the plane of a unit length on the surface.
    length: f64,
    /// Least weight of a triangle: one without area has to keep one in the plane.
    least: f64,
}

impl Scales {
    fn new(plane: f64, shape: Shape<'_>, triangles: &[[u32; 3]]) -> Self {
        let surface: f64 = triangles.iter().map(|&t| distortion::rest_area(shape.positions, t, shape.wanted)).sum();
        let surface = surface.max(1e-300);
        Self { length: (plane / surface).sqrt(), least: 1e-4 * surface / triangles.len().max(1) as f64 }
    }
}
