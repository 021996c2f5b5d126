//! Twin of shaders/bend.wgsl: particles follow the multipliers of bending.

use super::moments::Plate;
use crate::cpu::rows::Threads;
use crate::cpu::sheet::{Sheet, planes};
use crate::number::lanes::{Machine, Work, widest};
use crate::number::real::Real;

/// Rows that are done in one go.
const TOGETHER: usize = 32;

/// Moves every particle against the gradient of the energy of bending.
pub fn run<T: Real>(threads: &Threads, sheet: &mut Sheet<T>, plate: &Plate<T>) {
    let (half, height, row) = (sheet.half, sheet.height, sheet.row());
    let w = &sheet.w[..];
    threads.chunks(&mut sheet.now, TOGETHER * row, |chunk, rows| {
        widest(Rows { rows, first: chunk * TOGETHER, size: (half, height), w, plate });
    });
}

struct Rows<'a, 'b, T> {
    rows: &'b mut [T],
    first: usize,
    size: (usize, usize),
    w: &'a [T],
    plate: &'a Plate<T>,
}

impl<T: Real> Work<T> for Rows<'_, '_, T> {
    #[inline(always)]
    fn run<K: Machine<T>>(self, k: K) {
        let (half, height) = self.size;
        for (n, now) in self.rows.chunks_exact_mut(6 * half).enumerate() {
            let j = self.first + n;
            let w = &self.w[j * 2 * half..(j + 1) * 2 * half];
            let mut now = planes(now, half);
            let mut start = [T::of(0.0); 3];
            self.plate.weights.row(
                k,
                (j, height),
                &self.plate.moments,
                |at, sum| {
                    let w = k.load(w, at);
                    for c in 0..3 {
                        k.store(now[c], at, k.sub(k.load(now[c], at), k.mul(sum[c], w)));
                    }
                },
                |sum| start = sum,
            );
            for c in 0..3 {
                now[c][0] = now[c][0] - start[c] * w[0];
            }
        }
    }
}
