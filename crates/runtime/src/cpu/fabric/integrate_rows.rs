//! The rule of integrate.rs on sheets; the results are the same bits. Where exact, with shaders/part/verlet_exact.wgsl.

use crate::cpu::gust::airs;
use crate::cpu::integrate::Air;
use crate::cpu::rows::Threads;
use crate::cpu::sheet::{Sheet, columns, planes};
use crate::number::aligned::Aligned;
use crate::number::lanes::{Machine, Work, widest};
use crate::number::noise::LastCell;
use crate::number::real::Real;
use crate::step::Step;

/// Rows that are done in one go.
const TOGETHER: usize = 32;

/// One Verlet step. A field is in the layout of [`Sheet::now`]. `exact`: what is too small for a position to take up is added to the next step's
/// displacement, so that gravity and damping do their work however short the step is; after W. Kahan, "Further Remarks
/// on Reducing Truncation Errors", CACM 1965.
pub fn run<T: Real>(threads: &Threads, step: &Step<T>, sheet: &mut Sheet<T>, air: Air<T>, exact: bool) {
    let (half, row, width) = (sheet.half, sheet.row(), sheet.width);
    let w = &sheet.w[..];
    let size = TOGETHER * row;
    let work = |chunk: usize, now: &mut [T], before: &mut [T], lost: &mut [T]| {
        widest(Rows { step, now, before, lost, row, half, width, w, first: chunk * TOGETHER, air });
    };
    let both = (&mut sheet.now, &mut sheet.before);
    if exact {
        if sheet.lost.is_empty() {
            sheet.lost = Aligned::zeros(both.0.len());
        }
        threads.chunks3([both.0, both.1, &mut sheet.lost], size, |chunk, [now, before, lost]| {
            work(chunk, now, before, lost);
        });
    } else {
        threads.chunks2(both.0, both.1, (size, size), |chunk, now, before| work(chunk, now, before, &mut []));
    }
}

/// Rows in moving air, as [`run`], from the row `first` on.
pub fn moving<T: Real>(
    step: &Step<T>,
    now: &mut [T],
    before: &mut [T],
    (width, half): (usize, usize),
    (w, first): (&[T], usize),
    air: Air<T>,
) {
    widest(Rows { step, now, before, lost: &mut [], row: 6 * half, half, width, w, first, air });
}

/// Rows in still air, as [`run`], from the row `first` on.
#[inline(always)]
pub fn still<T: Real, K: Machine<T>>(
    k: K,
    step: &Step<T>,
    now: &mut [T],
    before: &mut [T],
    (width, half): (usize, usize),
    (w, first): (&[T], usize),
) {
    let rows = Rows { step, now, before, lost: &mut [], row: 6 * half, half, width, w, first, air: Air::None };
    rows.rows::<K, true, false>(k);
}

/// Rows of a sheet from the row `first` on.
struct Rows<'a, 'b, T> {
    step: &'a Step<T>,
    now: &'b mut [T],
    before: &'b mut [T],
    /// Empty, or as `now`.
    lost: &'b mut [T],
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
        match (self.air, self.lost.is_empty()) {
            (Air::None, true) => self.rows::<K, true, false>(k),
            (Air::None, false) => self.rows::<K, true, true>(k),
            (_, true) => self.rows::<K, false, false>(k),
            (_, false) => self.rows::<K, false, true>(k),
        }
    }
}

impl<T: Real> Rows<'_, '_, T> {
    #[inline(always)]
    fn rows<K: Machine<T>, const STILL: bool, const EXACT: bool>(self, k: K) {
        let Rows { step, row, half, width, w, air, lost, .. } = self;
        let zero = k.splat(T::of(0.0));
        let (keep, longest, scale) = (k.splat(step.keep), k.splat(step.longest), k.splat(step.scale));
        let [gx, gy, gz] = step.gravity;
        let gravity = [k.splat(gx), k.splat(gy), k.splat(gz)];
        let mut last = LastCell::default();
        for (n, (now, before)) in self.now.chunks_exact_mut(row).zip(self.before.chunks_exact_mut(row)).enumerate() {
            let j = self.first + n;
            let (now, before) = (planes(now, half), planes(before, half));
            let mut lost = EXACT.then(|| planes(&mut lost[n * row..(n + 1) * row], half));
            for at in columns(width, half, K::WIDE) {
                let free = k.above(k.load(w, j * 2 * half + at), zero);
                let p = [k.load(now[0], at), k.load(now[1], at), k.load(now[2], at)];
                let b = [k.load(before[0], at), k.load(before[1], at), k.load(before[2], at)];
                let moved = [k.sub(p[0], b[0]), k.sub(p[1], b[1]), k.sub(p[2], b[2])];
                let on = k.choose(k.above(k.squares(moved), longest), zero, keep);
                let a = if STILL {
                    gravity
                } else {
                    bent(k, step, (&air, &mut last), [p, moved], Place { row: j, half, at })
                };
                for c in 0..3 {
                    let to = if let Some(lost) = &mut lost {
                        let by = k.add(k.add(k.mul(moved[c], on), k.mul(a[c], scale)), k.load(lost[c], at));
                        let to = k.add(p[c], by);
                        k.store(lost[c], at, k.choose(free, k.sub(by, k.sub(to, p[c])), zero));
                        to
                    } else {
                        k.add(k.add(p[c], k.mul(moved[c], on)), k.mul(a[c], scale))
                    };
                    k.store(now[c], at, k.choose(free, to, p[c]));
                    k.store(before[c], at, k.choose(free, p[c], b[c]));
                }
            }
        }
    }
}

/// Particles `at` in a row of two halves.
#[derive(Clone, Copy)]
struct Place {
    row: usize,
    half: usize,
    at: usize,
}

/// Accelerations by gravity and air of some particles, given where they are and how they moved.
#[inline(always)]
fn bent<T: Real, K: Machine<T>>(
    k: K,
    step: &Step<T>,
    (air, last): (&Air<T>, &mut LastCell<T>),
    [p, moved]: [[K::V; 3]; 2],
    at: Place,
) -> [K::V; 3] {
    let gravity = k.splats(step.gravity);
    match air {
        Air::None => gravity,
        Air::Push => {
            let flow = k.minus(airs(k, step, last, p), k.times(moved, k.splat(step.rate)));
            k.plus(gravity, k.times(flow, k.splat(step.response)))
        }
        Air::Field(field) => {
            let Place { row, half, at } = at;
            let first = row * 6 * half + at;
            let there = [k.load(field, first), k.load(field, first + 2 * half), k.load(field, first + 4 * half)];
            k.plus(gravity, there)
        }
    }
}
