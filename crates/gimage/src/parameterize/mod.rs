//! A disk whose boundary lies on a rectangle -> a flip-free map of its inside.

mod blocks;
pub mod distortion;
mod newton;
mod refine;
mod sparse;
mod start;
mod system;

pub use newton::{NewtonOptions, NewtonRecord};

pub(crate) use start::StartRecord;
pub(crate) use system::System;

use distortion::{RestShapes, signed_area2};

/// What the solve did, for the report.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct ParameterizeRecord {
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

/// Maps the free vertices of a disk. `uv` holds the places of the fixed vertices, counter-clockwise around a rectangle;
/// the rest is filled in. A disk of many more than `enough` triangles goes by way of a simpler one. No triangle is flipped
/// on success. `None` if even the start could not be made free of flips in f64.
pub(crate) fn parameterize(
    shape: Shape<'_>,
    uv: &mut Vec<[f64; 2]>,
    passes: usize,
    options: &NewtonOptions,
    enough: usize,
) -> Option<ParameterizeRecord> {
    if shape.triangles.len() > 2 * enough {
        let mut fine = uv.clone();
        if let Some(record) = refine::coarse_to_fine(shape, &mut fine, passes, options, enough) {
            *uv = fine;
            return Some(record);
        }
    }
    let Shape { positions, triangles, wanted, fixed } = shape;
    let mut system = System::new(triangles, fixed);
    solve(&mut system, positions, triangles, wanted, uv, (passes, false), options)
}

/// As [`parameterize`], with a system that can be used again for other boundary places of the same surface. With no
/// `passes`, `uv` is a flip-free map already and goes on from there; if `placed`, it is the first pass of the start.
pub(crate) fn solve(
    system: &mut System,
    positions: &[[f64; 3]],
    triangles: &[[u32; 3]],
    wanted: &[f64],
    uv: &mut Vec<[f64; 2]>,
    (passes, placed): (usize, bool),
    options: &NewtonOptions,
) -> Option<ParameterizeRecord> {
    let StartRecord { passes, uniform } = match passes {
        0 => StartRecord { passes, uniform: false },
        _ => start::start(system, positions, triangles, wanted, uv, (passes, placed))?,
    };
    let plane: f64 = triangles.iter().map(|&t| 0.5 * signed_area2(distortion::planar(uv, t))).sum();
    let mut rest = system.rest.take().unwrap_or_else(|| RestShapes::new(positions, triangles, wanted));
    rest.set_scale((plane / rest.area.max(1e-300)).sqrt());
    let newton = newton::minimise(system, &rest.shapes, triangles, uv, options);
    let log_distortion = distortion::log_distortion(&rest.shapes, triangles, uv);
    system.rest = Some(rest);
    Some(ParameterizeRecord { start_passes: passes, uniform_start: uniform, log_distortion, newton })
}
