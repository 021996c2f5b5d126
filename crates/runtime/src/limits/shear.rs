//! What a diagonal spring may do in a step, so that crumpled cloth unfolds.

use crate::cloth::{Cloth, Rest};
use crate::options::Options;

/// Least bound, as a share of a diagonal's rest length.
const LEAST: f64 = 0.01;
/// From such a bound on there is none: no cloth but a heap has diagonals that short or long.
const MOST: f64 = 0.25;
/// Acceleration \[m/s^2\] that a diagonal gives its ends, for each particle along a side of the cloth: twenty times the weight of
/// such a row. Cloth that hangs asks for less, however it is held.
const EACH: f64 = 20.0 * 9.81;

/// Share of its rest length by which a diagonal may move its ends in a relaxation; 0 where there is no bound, as in steps that
/// are long for the size of the cells. As that of a force, it falls with the square of
/// the step, down to the least.
pub fn bound(cloth: &Cloth, options: &Options) -> f32 {
    let dt = options.step / f64::from(options.substeps);
    let springs = match cloth.rest() {
        Rest::None => return 0.0,
        _ if cloth.membrane().is_some() => return 0.0,
        Rest::Constant(lengths) | Rest::Image(lengths) => lengths,
    };
    let diagonals = springs.iter().flat_map(|l| [l[2], l[3]]).filter(|l| *l > 0.0);
    let shortest = f64::from(diagonals.fold(f32::INFINITY, f32::min));
    let side = cloth.grids().iter().map(|g| g.width.max(g.height)).max().unwrap_or(0);
    let share = (EACH * f64::from(side) * dt * dt / shortest).max(LEAST);
    // No diagonals at all have an infinite shortest one.
    if share < MOST && shortest.is_finite() { share as f32 } else { 0.0 }
}
