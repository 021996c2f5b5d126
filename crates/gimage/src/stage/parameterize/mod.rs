//! A disk whose boundary lies on a rectangle -> a flip-free map of its inside.

pub(crate) mod bend;
mod blocks;
pub mod distortion;
mod embed;
mod local;
pub(crate) mod map;
mod newton;
mod refine;
mod sparse;
mod start;
mod system;
mod tiles;
mod whole;

pub use map::{Map, Source, map};
pub use newton::{NewtonOptions, NewtonRecord};

pub(crate) use start::{Start, StartRecord};
pub(crate) use system::System;

#[cfg(test)]
mod tests;

use distortion::{RestShapes, signed_area2};

/// How a map was made.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Way {
    /// The mesh as it is, from a convex combination map.
    Whole,
    /// The map of a simplified mesh, its vertices put back.
    CoarseToFine,
    /// One inner vertex, the others put back one at a time.
    Embedded,
}

/// Record of the solve, for the report.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct ParameterizeRecord {
    /// How the map was made.
    pub way: Way,
    /// Reweighting passes of the start.
    pub start_passes: usize,
    /// The start fell back to uniform weights.
    pub uniform_start: bool,
    /// Mean of ln(density / 4) of the result, 0 for an isometry.
    pub log_distortion: f64,
    /// The minimiser's record.
    pub newton: NewtonRecord,
}

/// A disk to be mapped.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Shape<'a> {
    pub positions: &'a [[f64; 3]],
    pub triangles: &'a [[u32; 3]],
    /// The length a unit of length counts for at each vertex.
    pub wanted: &'a [f64],
    /// Vertices that stay where they are: the boundary.
    pub fixed: &'a [bool],
}

/// Energy of the better start above which the disk is embedded: convex combinations have crushed parts of it.
const POOR_START: f64 = 1e4;
/// Energy of a map above which it is compared with an embedding if it did not converge.
const POOR: f64 = 30.0;

/// Maps the free vertices of a disk by the first way that serves. `uv` holds the places of the fixed vertices,
/// counter-clockwise around a rectangle; the rest is filled in.
///
/// A disk of many more than `enough` triangles goes by way of a simpler one, others are mapped as they are; a disk that
/// neither serves is embedded. No triangle is flipped on success. Every disk whose boundary vertices are distinct, with
/// no inner edge between two of them, has a map; `None` only where f64 has no number between two that a vertex would have
/// to go between, so that a caller needs no way out in practice but must not count on a map in type.
/// Cost: that of the maps tried, at most three.
pub(crate) fn parameterize(
    shape: Shape<'_>,
    uv: &mut Vec<[f64; 2]>,
    passes: usize,
    options: &NewtonOptions,
    enough: usize,
) -> Option<ParameterizeRecord> {
    let large = shape.triangles.len() > 2 * enough;
    let mut map = uv.clone();
    let first = match large {
        true => refine::coarse_to_fine(shape, &mut map, passes, options, enough),
        false => whole::whole(shape, &mut map, passes, options, POOR_START),
    };
    if let Some(record) = first
        && (record.newton.converged || record.newton.end <= POOR || large)
    {
        *uv = map;
        return Some(record);
    }
    let mut other = uv.clone();
    let second = embed::embed(shape, &mut other, options, enough);
    let better = |a: &ParameterizeRecord, b: &ParameterizeRecord| a.newton.end <= b.newton.end;
    match (first, second) {
        (Some(a), b) if b.is_none_or(|b| better(&a, &b)) => {
            *uv = map;
            Some(a)
        }
        (_, Some(b)) => {
            *uv = other;
            Some(b)
        }
        _ => whole::whole(shape, uv, passes, options, f64::INFINITY),
    }
}

/// As [`parameterize`], by one way only. `None` where that way has no map free of flips.
pub(crate) fn parameterize_by(
    way: Way,
    shape: Shape<'_>,
    uv: &mut Vec<[f64; 2]>,
    passes: usize,
    options: &NewtonOptions,
    enough: usize,
) -> Option<ParameterizeRecord> {
    match way {
        Way::Whole => whole::whole(shape, uv, passes, options, f64::INFINITY),
        Way::CoarseToFine => refine::coarse_to_fine(shape, uv, passes, options, enough),
        Way::Embedded => embed::embed(shape, uv, options, enough),
    }
}

/// Sets the scale of shapes at rest to that of a map.
fn scale_to(rest: &mut RestShapes, triangles: &[[u32; 3]], uv: &[[f64; 2]]) {
    let plane: f64 = triangles.iter().map(|&t| 0.5 * signed_area2(distortion::planar(uv, t))).sum();
    rest.set_scale((plane / rest.area.max(1e-300)).sqrt());
}

/// As [`parameterize`], with a system that can be used again for other boundary places of the same surface.
pub(crate) fn solve(
    system: &mut System,
    shape: Shape<'_>,
    uv: &mut Vec<[f64; 2]>,
    start: Start,
    options: &NewtonOptions,
) -> Option<ParameterizeRecord> {
    let Shape { positions, triangles, wanted, .. } = shape;
    let StartRecord { passes, uniform } = match start {
        Start::Map => StartRecord { passes: 0, uniform: false },
        _ => start::convex(system, shape, uv, start)?,
    };
    let mut rest = system.rest.take().unwrap_or_else(|| RestShapes::new(positions, triangles, wanted));
    scale_to(&mut rest, triangles, uv);
    let newton = newton::minimise(system, &rest.shapes, triangles, uv, options);
    let log_distortion = distortion::log_distortion(&rest.shapes, triangles, uv);
    system.rest = Some(rest);
    Some(ParameterizeRecord { way: Way::Whole, start_passes: passes, uniform_start: uniform, log_distortion, newton })
}
