//! Twin of shaders/moments.wgsl: the multipliers of bending.

use std::sync::Arc;

use super::laplacian::Weights;
use crate::cloth::{Cloth, Grid};
use crate::cpu::rows::Threads;
use crate::cpu::sheet::{Sheet, planes};
use crate::number::lanes::{Machine, Work, widest};
use crate::number::real::Real;

/// Rows that are done in one go.
const TOGETHER: usize = 32;

/// How a sheet bends.
pub struct Plate<T> {
    pub weights: Arc<Weights<T>>,
    /// Compliance \[m/N\], in the layout of [`Sheet::w`]; 0 where there is no moment.
    pub compliance: Arc<Vec<T>>,
    /// Least compliance over the square of the step \[1/kg\].
    pub bound: Arc<Vec<T>>,
    /// Multipliers, in the layout of [`Sheet::now`].
    pub moments: Vec<T>,
}

/// How the sheets bend; empty for cloth that does so freely.
pub fn plates<T: Real>(cloth: &Cloth, sheets: &[Sheet<T>]) -> Vec<Plate<T>> {
    let Some(bending) = cloth.bending() else { return Vec::new() };
    let bounds = bending.bounds(cloth);
    let plate = |(sheet, grid): (&Sheet<T>, &Grid)| {
        let (first, zero) = (grid.first as usize, T::of(0.0));
        Plate {
            weights: Arc::new(Weights::new(sheet, |k| bending.weights[first + k])),
            compliance: Arc::new(sheet.list(zero, |k| T::of(bending.compliance[first + k].into()))),
            bound: Arc::new(sheet.list(zero, |k| T::of(bounds[first + k].into()))),
            moments: vec![zero; sheet.now.len()],
        }
    };
    sheets.iter().zip(cloth.grids()).map(plate).collect()
}

/// Multipliers of a step of `dt` \[s\]: the Laplacian of position, over compliance / dt^2 or, in longer steps, over what
/// keeps a step of any length from going too far: then cloth bends more easily than it should.
pub fn run<T: Real>(threads: &Threads, sheet: &Sheet<T>, plate: &mut Plate<T>, dt: T) {
    let row = sheet.row();
    let Plate { weights, compliance, bound, moments } = plate;
    let (weights, compliance, bound) = (&**weights, &compliance[..], &bound[..]);
    threads.chunks(moments, TOGETHER * row, |chunk, rows| {
        widest(Rows { rows, first: chunk * TOGETHER, sheet, weights, compliance, bound, span: dt * dt });
    });
}

struct Rows<'a, 'b, T: Real> {
    rows: &'b mut [T],
    first: usize,
    sheet: &'a Sheet<T>,
    weights: &'a Weights<T>,
    compliance: &'a [T],
    bound: &'a [T],
    /// Square of the step \[s^2\].
    span: T,
}

impl<T: Real> Work<T> for Rows<'_, '_, T> {
    #[inline(always)]
    fn run<K: Machine<T>>(self, k: K) {
        let Rows { sheet, weights, span, .. } = self;
        let half = sheet.half;
        let (zero, one, square) = (k.splat(T::of(0.0)), k.splat(T::of(1.0)), k.splat(span));
        for (n, out) in self.rows.chunks_exact_mut(sheet.row()).enumerate() {
            let j = self.first + n;
            let single = j * 2 * half..(j + 1) * 2 * half;
            let (soft, bound) = (&self.compliance[single.clone()], &self.bound[single]);
            let mut out = planes(out, half);
            let mut start = [T::of(0.0); 3];
            weights.row(
                k,
                (j, sheet.height),
                &sheet.now,
                |at, sum| {
                    let soft = k.load(soft, at);
                    let scale = k.div(one, k.most(k.div(soft, square), k.load(bound, at)));
                    let there = k.above(soft, zero);
                    for c in 0..3 {
                        k.store(out[c], at, k.choose(there, k.mul(sum[c], scale), zero));
                    }
                },
                |sum| start = sum,
            );
            let scale = T::of(1.0) / (soft[0] / span).max(bound[0]);
            for c in 0..3 {
                out[c][0] = if soft[0] > T::of(0.0) { start[c] * scale } else { T::of(0.0) };
            }
        }
    }
}
