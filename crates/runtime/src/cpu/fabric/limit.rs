//! Twin of shaders/limit.wgsl: no particle is farther from its target than its limit.

use std::marker::PhantomData;

use super::tethers::hold_within;
use crate::cloth::{Cloth, Grid};
use crate::cpu::rows::Threads;
use crate::cpu::sheet::{Sheet, planes, planes_ref};
use crate::memory::Tally;
use crate::number::aligned::Aligned;
use crate::number::lanes::{Machine, Work, widest};
use crate::number::real::{Real, V3};

/// The limits of a sheet.
pub struct Limit<T: Real> {
    /// Target positions \[m\]; in the layout of [`Sheet::now`].
    pub(super) targets: Aligned<T>,
    /// How fast each gets there \[m/s\], as `targets`; empty if none moves.
    pub(super) drifts: Aligned<T>,
    /// Largest distance \[m\], `f32::MAX` for no limit; in the layout of [`Sheet::w`].
    pub(super) most: Vec<T>,
    /// The texels of the sheet that have a limit.
    pub limited: Vec<u32>,
}

impl<T: Real> Limit<T> {
    /// From the target \[m\] and the limit \[m\] of each texel, below 0 for none.
    pub fn new(sheet: &Sheet<T>, of: impl Fn(usize) -> ([f32; 3], f32)) -> Self {
        let mut targets = Aligned::zeros(sheet.now.len());
        for k in 0..sheet.width * sheet.height {
            let (at, place) = (of(k).0, sheet.triple(k));
            (0..3).for_each(|c| targets[place + 2 * c * sheet.half] = T::of(at[c].into()));
        }
        let none = f64::from(f32::MAX);
        let most = |k: usize| if of(k).1 < 0.0 { none } else { f64::from(of(k).1) };
        let limited = (0..sheet.width * sheet.height).filter(|k| of(*k).1 >= 0.0).map(|k| k as u32).collect();
        Limit { targets, drifts: Aligned::default(), most: sheet.list(T::of(none), |k| T::of(most(k))), limited }
    }

    /// Other targets \[m\] of the texels that have a limit, in order, each on its way there at `rate` \[1/s\].
    pub fn lead(&mut self, sheet: &Sheet<T>, ends: &[V3<T>], rate: T) {
        if self.drifts.len() != self.targets.len() {
            self.drifts = Aligned::zeros(self.targets.len());
        }
        for (k, end) in self.limited.iter().zip(ends) {
            let place = sheet.triple(*k as usize);
            for (c, x) in end.iter().enumerate() {
                let at = place + 2 * c * sheet.half;
                self.drifts[at] = (*x - self.targets[at]) * rate;
                self.targets[at] = *x;
            }
        }
    }

    /// Numbers that it takes.
    pub fn tally(&self, tally: &mut Tally) {
        [&self.targets, &self.drifts].into_iter().for_each(|list| tally.state(list));
        tally.state(&self.most);
        tally.state(&self.limited);
    }
}

/// How far particles may be from where they begin; empty for cloth without limits.
pub fn limits<T: Real>(cloth: &Cloth, sheets: &[Sheet<T>]) -> Vec<Limit<T>> {
    let Some(limits) = &cloth.limits else { return Vec::new() };
    let of = |(sheet, grid): (&Sheet<T>, &Grid)| {
        Limit::new(sheet, |k| (cloth.positions()[grid.first as usize + k], limits[grid.first as usize + k]))
    };
    sheets.iter().zip(cloth.grids()).map(of).collect()
}

/// Rows that are done in one go.
const TOGETHER: usize = 32;

/// Draws every particle beyond its limit back to it, with `left` \[s\] of the frame to go after the step.
pub fn run<T: Real>(threads: &Threads, sheet: &mut Sheet<T>, limit: &Limit<T>, left: T) {
    run_with::<T, Within>(threads, sheet, limit, left);
}

/// A rule that holds particles near their targets, or away from them.
pub trait Hold {
    /// Holds the free particles of a vector, at `at`, by a distance \[m\] from `to`, `f32::MAX` for no rule; `w` are their inverse masses.
    fn hold<T: Real, K: Machine<T>>(k: K, p: [&mut [T]; 3], at: usize, to: [K::V; 3], limits: (K::V, K::V));
}

/// At most the distance.
struct Within;

impl Hold for Within {
    #[inline(always)]
    fn hold<T: Real, K: Machine<T>>(k: K, p: [&mut [T]; 3], at: usize, to: [K::V; 3], limits: (K::V, K::V)) {
        hold_within(k, p, at, to, limits);
    }
}

/// Applies a rule to every particle that has a target, as [`run`] does.
pub fn run_with<T: Real, H: Hold>(threads: &Threads, sheet: &mut Sheet<T>, limit: &Limit<T>, left: T) {
    let (half, row) = (sheet.half, sheet.row());
    let w = &sheet.w[..];
    threads.chunks(&mut sheet.now, TOGETHER * row, |chunk, rows| {
        widest(Rows { rows, first: chunk * TOGETHER, half, w, limit, left, rule: PhantomData::<H> });
    });
}

struct Rows<'a, 'b, T: Real, H> {
    rows: &'b mut [T],
    first: usize,
    half: usize,
    w: &'a [T],
    limit: &'a Limit<T>,
    left: T,
    rule: PhantomData<H>,
}

impl<'a, T: Real, H: Hold> Work<T> for Rows<'a, '_, T, H> {
    #[inline(always)]
    fn run<K: Machine<T>>(self, k: K) {
        let (wide, left) = (2 * self.half, k.splat(self.left));
        let none = k.splat(T::of(f64::from(f32::MAX)));
        for (n, row) in self.rows.chunks_exact_mut(3 * wide).enumerate() {
            let j = self.first + n;
            let (w, most) = (&self.w[j * wide..(j + 1) * wide], &self.limit.most[j * wide..(j + 1) * wide]);
            let of_row = |list: &'a Aligned<T>| planes_ref(&list[j * 3 * wide..(j + 1) * 3 * wide], self.half);
            let to = of_row(&self.limit.targets);
            let drifts = (!self.limit.drifts.is_empty()).then(|| of_row(&self.limit.drifts));
            let [x, y, z] = planes(row, self.half);
            for at in (0..wide).step_by(K::WIDE) {
                if !k.any(k.above(none, k.load(most, at))) {
                    continue;
                }
                let mut to = to.map(|list| k.load(list, at));
                if let Some(drifts) = drifts {
                    to = k.minus(to, k.times(drifts.map(|list| k.load(list, at)), left));
                }
                H::hold(k, [&mut *x, &mut *y, &mut *z], at, to, (k.load(w, at), k.load(most, at)));
            }
        }
    }
}
