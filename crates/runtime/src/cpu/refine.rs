//! Twin of shaders/refine.wgsl: particles follow the nodes of the finest level.

use super::interpolate::{add, interpolate};
use super::pyramid::Pyramid;
use super::real::Real;
use super::sheet::Sheet;

/// Share of the displacement that carries no velocity on. With all of it, cloth would fall on behind its limits; with
/// much less, limits would throw it back.
pub const CARRIED: f64 = 0.9;

/// Moves particles, and most of the way their previous positions too.
pub fn run<T: Real>(pyramid: &Pyramid<T>, sheet: &mut Sheet<T>) {
    let Some(field) = pyramid.field() else { return };
    let Sheet { width, height, half, now, before, w, .. } = sheet;
    let (row, half) = (6 * *half, *half);
    interpolate((*width, *height, half), &field, |j, even, odd| {
        let w = &w[j * 2 * half..];
        add(&mut now[j * row..], w, half, even, odd, T::of(1.0));
        add(&mut before[j * row..], w, half, even, odd, T::of(CARRIED));
    });
}
