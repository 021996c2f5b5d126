//! Distances of one point from many colliders, for as many colliders at once as the machine has lanes.

use super::Near;
use crate::number::lanes::{LANES, Machine};
use crate::number::real::{Real, V3};

/// From this number of colliders on, those that a vector of particles is far from are told apart together.
const MANY: usize = 8;

/// Colliders as lines with a radius, in their order; a half-space is near everything.
pub struct Crowd<T> {
    center: [Vec<T>; 3],
    axis: [Vec<T>; 3],
    half: Vec<T>,
    /// How far \[m\] from the line the collider can touch up to the end of the frame.
    radius: Vec<T>,
}

impl<T: Real> Crowd<T> {
    /// None of few colliders.
    pub fn new(near: &[Near<T>]) -> Option<Self> {
        if near.len() < MANY {
            return None;
        }
        let room = near.len().next_multiple_of(LANES);
        let list = || vec![T::of(0.0); room];
        let lists = || [list(), list(), list()];
        let mut all = Crowd { center: lists(), axis: lists(), half: list(), radius: list() };
        for (n, near) in near.iter().enumerate() {
            let (center, axis, half, radius) = near.reach.line();
            (0..3).for_each(|c| (all.center[c][n], all.axis[c][n]) = (center[c], axis[c]));
            (all.half[n], all.radius[n]) = (half, radius + near.ahead);
        }
        Some(all)
    }

    /// How far \[m\] a point is from what the colliders from `at` on can touch up to the end of the frame.
    #[inline(always)]
    pub fn apart<K: Machine<T>>(&self, k: K, at: usize, p: V3<T>) -> [T; LANES] {
        let d = k.minus(k.splats(p), k.loads(&self.center, at));
        let axis = k.loads(&self.axis, at);
        let half = k.load(&self.half, at);
        let along = k.least(k.most(k.dot(d, axis), k.sub(k.splat(T::of(0.0)), half)), half);
        let across = k.minus(d, k.times(axis, along));
        let mut out = [T::of(0.0); LANES];
        k.store(&mut out, 0, k.sub(k.sqrt(k.squares(across)), k.load(&self.radius, at)));
        out
    }
}
