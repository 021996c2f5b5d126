//! Twin of shaders/refine.wgsl: particles follow the nodes of the finest level.

use super::pyramid::Pyramid;
use crate::cpu::interpolate::{add, interpolate};
use crate::cpu::sheet::Sheet;
use crate::number::real::Real;

/// Moves particles, and their previous positions by a share of that, `carried`.
pub fn run<T: Real>(pyramid: &Pyramid<T>, sheet: &mut Sheet<T>, carried: f64) {
    let Some(field) = pyramid.field() else { return };
    let Sheet { width, height, half, now, before, w, .. } = sheet;
    let (row, half) = (6 * *half, *half);
    interpolate([*width, *height], half, &field, |j, even, odd| {
        let w = &w[j * 2 * half..];
        add(&mut now[j * row..], w, half, even, odd, T::of(1.0));
        add(&mut before[j * row..], w, half, even, odd, T::of(carried));
    });
}
