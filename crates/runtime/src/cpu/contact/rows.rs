//! Which colliders the particles of some rows meet, vector by vector.

use super::clear::Block;
use super::{Near, wide};
use crate::cpu::sheet::{planes, planes_ref};
use crate::number::lanes::{LANES, Machine, Work};
use crate::number::real::Real;
use std::sync::atomic::{AtomicUsize, Ordering};

/// Rows of a sheet from the row `first` on, and what they can touch.
pub struct Rows<'a, 'b, T> {
    pub rows: &'b mut [T],
    pub lists: Lists<'b, T>,
    pub row: usize,
    pub half: usize,
    pub w: &'a [T],
    pub before: &'a [T],
    pub first: usize,
    pub near: &'a [Near<'a, T>],
    pub dt: T,
}

/// The lists of some rows.
pub struct Lists<'a, T> {
    pub blocks: &'a mut [Block<T>],
    /// Whether they are used; none is read or written otherwise.
    pub takes: bool,
    /// Tests of vectors with groups that they spared.
    pub spared: &'a AtomicUsize,
    /// A length \[m\] above all rounding.
    pub slack: T,
    /// Steps in which a list should last at the present speed.
    pub steps: T,
    /// Colliders in a group.
    pub group: usize,
}

/// A vector of particles: where it starts in its row, its inverse masses and where it was.
struct Vector<'a, 'b, 'c, T: Real, K: Machine<T>> {
    k: K,
    now: &'a mut [&'b mut [T]; 3],
    was: [&'c [T]; 3],
    w: &'c [T],
    at: usize,
    free: K::M,
    dt: T,
}

impl<T: Real, K: Machine<T>> Vector<'_, '_, '_, T, K> {
    #[inline(always)]
    fn load(&self) -> [K::V; 3] {
        let (k, at) = (self.k, self.at);
        [k.load(self.now[0], at), k.load(self.now[1], at), k.load(self.now[2], at)]
    }

    /// The square of its way to `p`.
    #[inline(always)]
    fn way2(&self, p: [K::V; 3]) -> K::V {
        let (k, at) = (self.k, self.at);
        k.squares(k.minus(p, [k.load(self.was[0], at), k.load(self.was[1], at), k.load(self.was[2], at)]))
    }

    /// Meets a collider where particles of the mask are near; where they are afterwards.
    #[inline(always)]
    fn meet(&mut self, near: &Near<T>, mask: K::M) -> [K::V; 3] {
        let lines = wide::Lines { now: self.now, was: self.was, w: &self.w[self.at..] };
        wide::meet(self.k, (near.solid, &near.reach), lines, (self.at, mask), self.dt);
        self.load()
    }
}

impl<T: Real> Work<T> for Rows<'_, '_, T> {
    #[inline(always)]
    fn run<K: Machine<T>>(self, k: K) {
        let Rows { row, half, near, dt, lists: Lists { blocks, takes, spared, slack, steps, group }, .. } = self;
        let (more, slack, steps) = (k.splat(T::of(1.001)), k.splat(slack), k.splat(steps));
        let (zero, none) = (k.splat(T::of(0.0)), k.splat(T::of(f64::from(f32::MAX))));
        let twice = k.splat(T::of(2.01));
        let groups = near.len().div_ceil(group);
        let mut unlisted = 0;
        let each = self.rows.chunks_exact_mut(row).zip(blocks.chunks_exact_mut(2 * half / LANES));
        for (n, (now, blocks)) in each.enumerate() {
            let j = self.first + n;
            let was = planes_ref(&self.before[j * row..(j + 1) * row], half);
            let w = &self.w[j * 2 * half..(j + 1) * 2 * half];
            let mut now = planes(now, half);
            for at in (0..2 * half).step_by(K::WIDE) {
                let free = k.above(k.load(w, at), zero);
                if !k.any(free) {
                    // Padding too.
                    unlisted += groups;
                    continue;
                }
                let mut of = Vector { k, now: &mut now, was, w, at, free, dt };
                if !takes {
                    every(of, near);
                    continue;
                }
                let (start, block, lane) = (of.load(), &mut blocks[at / LANES], at % LANES);
                let (way2, room) = (of.way2(start), k.load(&block.room, lane));
                let moved2 = k.squares(k.minus(start, block.at(k, lane)));
                // Without roots: (moved + way)^2 is at most 2 (moved^2 + way^2). NaN has no room.
                let used2 = k.mul(twice, k.add(moved2, way2));
                if !k.any(k.without(free, k.above(k.mul(room, room), used2))) {
                    unlisted += groups - block.listed.count_ones() as usize;
                    if block.listed == 0 {
                        continue;
                    }
                    let way = k.mul(k.sqrt(way2), more);
                    let pushed = listed(&mut of, near, (block.listed, group), (start, way));
                    if !k.any(k.above(pushed, zero)) {
                        continue;
                    }
                    // Pushes can be towards a collider that is not in the list, and make the way longer.
                    let used = k.add(k.add(k.mul(k.sqrt(moved2), more), way), k.add(pushed, pushed));
                    if !k.any(k.without(free, k.above(room, used))) {
                        continue;
                    }
                    k.store(of.now[0], at, start[0]);
                    k.store(of.now[1], at, start[1]);
                    k.store(of.now[2], at, start[2]);
                }
                // Vectors that are shorter than a block share its list.
                let mut list = if K::WIDE == LANES { 0 } else { block.listed };
                let (mut p, mut way2, mut pushed) = (start, way2, zero);
                let way = k.mul(k.sqrt(way2), more);
                let (margin, mut left) = (k.add(k.mul(way, steps), slack), none);
                for (n, near) in near.iter().enumerate() {
                    let (apart, close) = near.reach.near(k, p, way2);
                    let spare = k.sub(apart, k.splat(near.ahead));
                    if k.any(k.without(free, k.above(spare, margin))) {
                        list |= 1 << (n / group);
                    } else {
                        left = k.least(spare, left);
                    }
                    if k.any(k.both(close, free)) {
                        let to = of.meet(near, close);
                        pushed = k.add(pushed, k.mul(k.sqrt(k.squares(k.minus(to, p))), more));
                        (p, way2) = (to, of.way2(to));
                    }
                }
                k.store(&mut block.at[0], lane, start[0]);
                k.store(&mut block.at[1], lane, start[1]);
                k.store(&mut block.at[2], lane, start[2]);
                k.store(&mut block.room, lane, k.most(k.sub(left, k.add(pushed, slack)), zero));
                block.listed = list;
            }
        }
        spared.fetch_add(unlisted * K::WIDE / LANES, Ordering::Relaxed);
    }
}

/// Meets all colliders.
#[inline(always)]
fn every<T: Real, K: Machine<T>>(mut of: Vector<T, K>, near: &[Near<T>]) {
    let k = of.k;
    let mut p = of.load();
    let mut way2 = of.way2(p);
    for near in near {
        if !k.any(k.both(near.reach.may_be_near(k, p, way2), of.free)) {
            continue;
        }
        let way = k.mul(k.sqrt(way2), k.splat(T::of(1.001)));
        if let (close, true) = near.reach.touches(k, p, way, of.free) {
            p = of.meet(near, close);
            way2 = of.way2(p);
        }
    }
}

/// Meets the colliders of groups with a bit; returns how far particles were pushed.
#[inline(always)]
fn listed<T: Real, K: Machine<T>>(
    of: &mut Vector<T, K>,
    near: &[Near<T>],
    (mut list, group): (u64, usize),
    (mut p, mut way): ([K::V; 3], K::V),
) -> K::V {
    let (k, more) = (of.k, of.k.splat(T::of(1.001)));
    let mut pushed = k.splat(T::of(0.0));
    while list != 0 {
        let first = list.trailing_zeros() as usize * group;
        list &= list - 1;
        for near in &near[first..(first + group).min(near.len())] {
            let (close, meets) = near.reach.touches(k, p, way, of.free);
            if !meets {
                continue;
            }
            let to = of.meet(near, close);
            pushed = k.add(pushed, k.mul(k.sqrt(k.squares(k.minus(to, p))), more));
            (p, way) = (to, k.mul(k.sqrt(of.way2(to)), more));
        }
    }
    pushed
}
