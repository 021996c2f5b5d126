//! The rule of integrate.rs on sheets; the results are the same bits.

use super::integrate::{Air, push};
use super::lanes::{LANES, each, load, points, store, widest};
use super::real::Real;
use super::rows::Threads;
use super::sheet::{Sheet, planes};
use crate::step::Step;

/// Rows that are done in one go.
const TOGETHER: usize = 32;

/// One Verlet step. A field is by texels.
pub fn run<T: Real>(threads: &Threads, step: &Step<T>, sheet: &mut Sheet<T>, air: Air<T>) {
    let (half, row, width) = (sheet.half, sheet.row(), sheet.width);
    let w = &sheet.w[..];
    let zero = T::of(0.0);
    threads.chunks2(&mut sheet.now, &mut sheet.before, (TOGETHER * row, TOGETHER * row), |chunk, now, before| {
        widest(
            #[inline(always)]
            || {
                for (n, (now, before)) in now.chunks_exact_mut(row).zip(before.chunks_exact_mut(row)).enumerate() {
                    let j = chunk * TOGETHER + n;
                    let (now, before) = (planes(now, half), planes(before, half));
                    for at in (0..2 * half).step_by(LANES) {
                        let w = load(w, j * 2 * half + at);
                        let p = points([&*now[0], &*now[1], &*now[2]], at);
                        let b = points([&*before[0], &*before[1], &*before[2]], at);
                        let moved = [0, 1, 2].map(|c| each(|k| p[c][k] - b[c][k]));
                        let far = super::lanes::squares(&moved);
                        let on = each(|k| if far[k] > step.longest { zero } else { step.keep });
                        let a = match air {
                            Air::None => step.gravity.map(super::lanes::splat),
                            _ => bent(step, &air, [&p, &moved], (j * width, width, half, at)),
                        };
                        for c in 0..3 {
                            let next = each(|k| p[c][k] + moved[c][k] * on[k] + a[c][k] * step.scale);
                            store(&mut *now[c], at, &each(|k| if w[k] > zero { next[k] } else { p[c][k] }));
                            store(&mut *before[c], at, &each(|k| if w[k] > zero { p[c][k] } else { b[c][k] }));
                        }
                    }
                }
            },
        );
    });
}

/// Accelerations in wind.
fn bent<T: Real>(
    step: &Step<T>,
    air: &Air<T>,
    [p, moved]: [&[[T; LANES]; 3]; 2],
    (first, width, half, at): (usize, usize, usize, usize),
) -> [[T; LANES]; 3] {
    let mut out = [[T::of(0.0); LANES]; 3];
    for k in 0..LANES {
        let (place, odd) = ((at + k) % half, (at + k) / half);
        let i = 2 * place + odd;
        if i >= width {
            continue;
        }
        let more = match air {
            Air::None => [T::of(0.0); 3],
            Air::Push => push(step, p.map(|c| c[k]), moved.map(|c| c[k])),
            Air::Field(field) => [0, 1, 2].map(|c| field[first + i][c]),
        };
        (0..3).for_each(|c| out[c][k] = step.gravity[c] + more[c]);
    }
    out
}
