//! The nearest particles of other cloths that a particle has met so far.

use super::MAX_OTHERS;
use crate::number::real::Real;

/// Those of other cloths that are nearest to a particle so far, the nearest first.
#[derive(Clone, Copy)]
pub struct Nearest<T> {
    pub count: usize,
    /// Square of the smallest distance \[m^2\] in the frame; infinite where there is none.
    near: [T; MAX_OTHERS],
    /// The shadow among all, and the place there.
    pub from: [[u32; 2]; MAX_OTHERS],
}

impl<T: Real> Nearest<T> {
    /// None yet.
    pub fn none() -> Self {
        Nearest { count: 0, near: [T::of(f64::INFINITY); MAX_OTHERS], from: [[u32::MAX; 2]; MAX_OTHERS] }
    }

    /// Square of the distance of the last one of a full list, else infinite: none that is farther takes its place.
    #[inline(always)]
    pub fn last(&self) -> T {
        self.near[MAX_OTHERS - 1]
    }

    /// Takes in a particle if it is among the nearest; of those equally near the one that comes first.
    #[inline(always)]
    pub fn take(&mut self, near: T, from: [u32; 2]) {
        if near >= self.last() {
            return;
        }
        let mut at = MAX_OTHERS - 1;
        while at > 0 && self.near[at - 1] > near {
            (self.near[at], self.from[at]) = (self.near[at - 1], self.from[at - 1]);
            at -= 1;
        }
        (self.near[at], self.from[at]) = (near, from);
        self.count = (self.count + 1).min(MAX_OTHERS);
    }
}
