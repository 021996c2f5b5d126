//! Bound on the correction by a diagonal spring in a step, so that crumpled cloth unfolds.

use super::{Cloth, Rest};

/// Least bound, as a share of a diagonal's rest length.
const LEAST: f64 = 0.01;
/// From such a bound on there is none: no cloth but a heap has diagonals that short or long.
const MOST: f64 = 0.25;
/// Acceleration \[m/s^2\] that a diagonal gives its ends, for each particle along a side of the cloth: twenty times the weight of
/// such a row. Cloth that hangs asks for less, however it is held.
const EACH: f64 = 20.0 * 9.81;

/// Bound on corrections by diagonals, as a share of their rest length over the square of a step \[1/s^2\]; 0 for none.
pub fn strength(cloth: &Cloth) -> f64 {
    let springs = match cloth.rest() {
        Rest::None => return 0.0,
        _ if cloth.membrane().is_some() => return 0.0,
        Rest::Constant(lengths) | Rest::Image(lengths) => lengths,
    };
    let diagonals = springs.iter().flat_map(|l| [l[2], l[3]]).filter(|l| *l > 0.0);
    let shortest = f64::from(diagonals.fold(f32::INFINITY, f32::min));
    let side = cloth.grids().iter().map(|g| g.width.max(g.height)).max().unwrap_or(0);
    // No diagonals at all have an infinite shortest one.
    EACH * f64::from(side) / shortest
}

/// Share of its rest length by which a diagonal may move its ends in a relaxation of a step of `dt` \[s\]; 0 where there is no
/// bound, as in steps that are long for the size of the cells. As that of a force, it falls with the square of the step, down
/// to the least.
pub fn bound(strength: f64, dt: f64) -> f32 {
    let share = (strength * dt * dt).max(LEAST);
    if strength > 0.0 && share < MOST { share as f32 } else { 0.0 }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::Flat;

    #[test]
    fn the_bound_falls_with_the_square_of_the_step() {
        let strength = strength(&Flat::square("x", 17).cloth().unwrap());
        let of = |substeps: f64| bound(strength, 1.0 / 60.0 / substeps);
        assert!((of(8.0) / of(16.0) - 4.0).abs() < 1e-5 && of(8.0) < MOST as f32, "{} {}", of(8.0), of(16.0));
        assert_eq!((of(4.0), of(64.0), bound(0.0, 1e-4)), (0.0, LEAST as f32, 0.0));
    }
}
