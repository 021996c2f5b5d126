//! Twin of shaders/cut_levels.wgsl: after a cut the coarser grids are rebuilt from the springs that are left.

use super::pyramid::Pyramid;
use crate::cloth::other_end;
use crate::levels::Below;
use crate::number::real::Real;

/// The pyramid of a grid of `width` columns with these rest lengths \[m\] and masses \[kg\] (0 where there is no particle).
/// Limits are those of a cloth without the springs that are cut, so none crosses a cut; nor does a displacement, as
/// particles follow only the nodes that springs still lead to ([`crate::levels::links`]).
pub fn run<T: Real>(width: usize, rest: &[[T; 4]], mass: &[f64]) -> Pyramid<T> {
    let height = rest.len() / width.max(1);
    let length = |k: usize, d: usize| {
        let other = other_end(width, height, k, d)?;
        (mass[k] > 0.0 && mass[other] > 0.0).then_some(rest[k][d])
    };
    let of = |k: usize| [0, 1, 2, 3].map(|d| length(k, d).unwrap_or(T::of(0.0)));
    let limits = (0..rest.len()).map(of).collect();
    let fine = Below { width: width as u32, height: height as u32, limits, mass: mass.to_vec() };
    Pyramid::new(&fine.levels(true), width)
}
