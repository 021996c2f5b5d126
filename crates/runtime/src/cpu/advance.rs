//! The rule of integrate.rs on sheets; the results are the same bits.

use super::integrate::{Air, push};
use super::lanes::{LANES, Points, load, splat, store, widest};
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
    threads.chunks2(&mut sheet.now, &mut sheet.before, (TOGETHER * row, TOGETHER * row), |chunk, now, before| {
        widest(
            #[inline(always)]
            || {
                for (n, (now, before)) in now.chunks_exact_mut(row).zip(before.chunks_exact_mut(row)).enumerate() {
                    let j = chunk * TOGETHER + n;
                    let (mut now, mut before) = (planes(now, half), planes(before, half));
                    for at in (0..2 * half).step_by(LANES) {
                        let w = load(w, j * 2 * half + at);
                        let (now, before) = (&mut now, &mut before);
                        match air {
                            Air::None => block(step, &w, now, before, at, |_, _| step.gravity.map(splat)),
                            _ => block(step, &w, now, before, at, |p, moved| {
                                bent(step, &air, [p, moved], (j * width, width, half, at))
                            }),
                        }
                    }
                }
            },
        );
    });
}

/// Both positions of a block move on.
#[inline(always)]
fn block<T: Real>(
    step: &Step<T>,
    w: &[T; LANES],
    now: &mut [&mut [T]; 3],
    before: &mut [&mut [T]; 3],
    at: usize,
    air: impl Fn(&Points<T>, &Points<T>) -> Points<T>,
) {
    let zero = T::of(0.0);
    let p = [load(now[0], at), load(now[1], at), load(now[2], at)];
    let b = [load(before[0], at), load(before[1], at), load(before[2], at)];
    let mut moved = [[zero; LANES]; 3];
    for c in 0..3 {
        for k in 0..LANES {
            moved[c][k] = p[c][k] - b[c][k];
        }
    }
    let mut on = [zero; LANES];
    for k in 0..LANES {
        let far = moved[0][k] * moved[0][k] + moved[1][k] * moved[1][k] + moved[2][k] * moved[2][k];
        on[k] = if far > step.longest { zero } else { step.keep };
    }
    let a = air(&p, &moved);
    for c in 0..3 {
        let (mut next, mut last) = ([zero; LANES], [zero; LANES]);
        for k in 0..LANES {
            let to = p[c][k] + moved[c][k] * on[k] + a[c][k] * step.scale;
            next[k] = if w[k] > zero { to } else { p[c][k] };
            last[k] = if w[k] > zero { p[c][k] } else { b[c][k] };
        }
        store(now[c], at, &next);
        store(before[c], at, &last);
    }
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
