//! The rule of integrate.rs on sheets; the results are the same bits.

use super::integrate::{Air, push};
use super::lanes::{LANES, Machine, Work, widest};
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
        widest(Rows { step, now, before, row, half, width, w, first: chunk * TOGETHER, air });
    });
}

/// Rows of a sheet from the row `first` on.
struct Rows<'a, 'b, T> {
    step: &'a Step<T>,
    now: &'b mut [T],
    before: &'b mut [T],
    row: usize,
    half: usize,
    width: usize,
    w: &'a [T],
    first: usize,
    air: Air<'a, T>,
}

impl<T: Real> Work<T> for Rows<'_, '_, T> {
    #[inline(always)]
    fn run<K: Machine<T>>(self, k: K) {
        match self.air {
            Air::None => self.rows::<K, true>(k),
            _ => self.rows::<K, false>(k),
        }
    }
}

impl<T: Real> Rows<'_, '_, T> {
    #[inline(always)]
    fn rows<K: Machine<T>, const STILL: bool>(self, k: K) {
        let Rows { step, row, half, width, w, air, .. } = self;
        let zero = k.splat(T::of(0.0));
        let (keep, longest, scale) = (k.splat(step.keep), k.splat(step.longest), k.splat(step.scale));
        let [gx, gy, gz] = step.gravity;
        let gravity = [k.splat(gx), k.splat(gy), k.splat(gz)];
        for (n, (now, before)) in self.now.chunks_exact_mut(row).zip(self.before.chunks_exact_mut(row)).enumerate() {
            let j = self.first + n;
            let (now, before) = (planes(now, half), planes(before, half));
            for at in (0..2 * half).step_by(K::WIDE) {
                let free = k.above(k.load(w, j * 2 * half + at), zero);
                let p = [k.load(now[0], at), k.load(now[1], at), k.load(now[2], at)];
                let b = [k.load(before[0], at), k.load(before[1], at), k.load(before[2], at)];
                let moved = [k.sub(p[0], b[0]), k.sub(p[1], b[1]), k.sub(p[2], b[2])];
                let on = k.choose(k.above(k.squares(moved), longest), zero, keep);
                let a = if STILL { gravity } else { bent(k, step, &air, [p, moved], (j * width, width, half, at)) };
                for c in 0..3 {
                    let to = k.add(k.add(p[c], k.mul(moved[c], on)), k.mul(a[c], scale));
                    k.store(now[c], at, k.choose(free, to, p[c]));
                    k.store(before[c], at, k.choose(free, p[c], b[c]));
                }
            }
        }
    }
}

/// Accelerations in wind.
#[inline(always)]
fn bent<T: Real, K: Machine<T>>(
    k: K,
    step: &Step<T>,
    air: &Air<T>,
    vectors: [[K::V; 3]; 2],
    (first, width, half, at): (usize, usize, usize, usize),
) -> [K::V; 3] {
    let list = |v: K::V| {
        let mut out = [T::of(0.0); LANES];
        k.store(&mut out, 0, v);
        out
    };
    let [p, moved] = vectors.map(|v| v.map(list));
    let mut out = [[T::of(0.0); LANES]; 3];
    for n in 0..K::WIDE {
        let (place, odd) = ((at + n) % half, (at + n) / half);
        let i = 2 * place + odd;
        if i >= width {
            continue;
        }
        let more = match air {
            Air::None => [T::of(0.0); 3],
            Air::Push => push(step, p.map(|c| c[n]), moved.map(|c| c[n])),
            Air::Field(field) => [0, 1, 2].map(|c| field[first + i][c]),
        };
        (0..3).for_each(|c| out[c][n] = step.gravity[c] + more[c]);
    }
    out.map(|c| k.load(&c, 0))
}
