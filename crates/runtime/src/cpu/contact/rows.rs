//! Which colliders the particles of some rows meet, vector by vector.

use super::clear::{Block, PAYS};
use super::crowd::Crowd;
use super::{Near, wide};
use crate::cpu::sheet::{planes, planes_ref};
use crate::number::lanes::{LANES, Machine, Work};
use crate::number::real::{Real, V3};
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
    /// All of them, if they are many.
    pub crowd: Option<&'a Crowd<T>>,
    pub dt: T,
}

/// The lists of some rows.
pub struct Lists<'a, T> {
    pub blocks: &'a mut [Block<T>],
    /// Whether they are used; none is read or written otherwise.
    pub takes: bool,
    /// Tests of vectors with groups that they spared, times [`PAYS`].
    pub spared: &'a AtomicUsize,
    /// A length \[m\] above all rounding.
    pub slack: T,
    /// Steps in which a list should last at the present speed.
    pub steps: T,
    /// Colliders in a group.
    pub group: usize,
}

/// A vector of particles: where it starts in its row, where its particles are and were, and which can move.
struct Vector<'a, 'b, 'c, T: Real, K: Machine<T>> {
    k: K,
    now: &'a mut [&'b mut [T]; 3],
    was: [&'c [T]; 3],
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

    /// Meets a collider where particles of the mask, at `p`, are near; where they are afterwards.
    #[inline(always)]
    fn meet(&mut self, near: &Near<T>, p: [K::V; 3], mask: K::M) -> [K::V; 3] {
        let lines = wide::Lines { now: self.now, was: self.was, free: self.free };
        wide::meet(self.k, (near.solid, near.reach), lines, (self.at, p, mask), self.dt)
    }
}

impl<T: Real> Work<T> for Rows<'_, '_, T> {
    #[inline(always)]
    fn run<K: Machine<T>>(self, k: K) {
        let Rows { row, half, near, crowd, dt, lists, .. } = self;
        let Lists { blocks, takes, spared, slack, steps, group } = lists;
        let (more, slack, steps) = (k.splat(T::of(1.001)), k.splat(slack), k.splat(steps));
        let zero = k.splat(T::of(0.0));
        let (twice, thrice, four) = (k.splat(T::of(2.01)), k.splat(T::of(3.02)), k.splat(T::of(4.0)));
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
                    // Padding too, of which narrow vectors have more. It counts neither for lists nor against them.
                    unlisted += groups;
                    continue;
                }
                let mut of = Vector { k, now: &mut now, was, at, free, dt };
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
                    unlisted += PAYS * (groups - block.listed.count_ones() as usize);
                    if block.listed == 0 {
                        continue;
                    }
                    let pushed = listed(&mut of, near, (block.listed, group), (start, way2));
                    if !k.any(k.above(pushed, zero)) {
                        continue;
                    }
                    // Pushes can be towards a collider that is not in the list, and make the way longer. Without roots at first:
                    // (moved + way + 2 pushed)^2 is at most 3 (moved^2 + way^2 + 4 pushed^2).
                    let used2 = k.mul(thrice, k.add(k.add(moved2, way2), k.mul(four, pushed)));
                    if !k.any(k.without(free, k.above(k.mul(room, room), used2))) {
                        continue;
                    }
                    let [moved, way, pushed] = [k.sqrt(moved2), k.sqrt(way2), k.sqrt(pushed)];
                    let used = k.mul(k.add(k.add(moved, way), k.add(pushed, pushed)), more);
                    if !k.any(k.without(free, k.above(room, used))) {
                        continue;
                    }
                    k.store(of.now[0], at, start[0]);
                    k.store(of.now[1], at, start[1]);
                    k.store(of.now[2], at, start[2]);
                }
                // Vectors that are shorter than a block share its list.
                let shared = if K::WIDE == LANES { 0 } else { block.listed };
                let way = k.mul(k.sqrt(way2), more);
                let found = Found { way, margin: k.add(k.mul(way, steps), slack), group };
                let (list, left, pushed) = build(&mut of, near, crowd, &found, (start, way2));
                k.store(&mut block.at[0], lane, start[0]);
                k.store(&mut block.at[1], lane, start[1]);
                k.store(&mut block.at[2], lane, start[2]);
                k.store(&mut block.room, lane, k.most(k.sub(left, k.add(pushed, slack)), zero));
                block.listed = shared | list;
            }
        }
        spared.fetch_add(unlisted * K::WIDE / LANES, Ordering::Relaxed);
    }
}

/// How far a list of a vector reaches.
struct Found<T: Real, K: Machine<T>> {
    /// At least the length \[m\] of the way of each particle in this step.
    way: K::V,
    /// Colliders that are farther \[m\] up to the end of the frame are left out of the list.
    margin: K::V,
    /// Colliders in a group.
    group: usize,
}

/// Meets all colliders, and lists the groups that are near; returns them, how far all others are from where the particles were, and how far
/// from there particles were pushed.
#[inline(always)]
fn build<T: Real, K: Machine<T>>(
    of: &mut Vector<T, K>,
    near: &[Near<T>],
    crowd: Option<&Crowd<T>>,
    found: &Found<T, K>,
    (start, start2): ([K::V; 3], K::V),
) -> (u64, K::V, K::V) {
    let k = of.k;
    let (zero, none) = (k.splat(T::of(0.0)), T::of(f64::from(f32::MAX)));
    let mut crowd = match crowd {
        Some(crowd) => Some((crowd, Ball::around(of, start, found.margin))),
        None => None,
    };
    loop {
        let (mut p, mut way2, mut pushed, mut list) = (start, start2, zero, 0);
        // Of colliders that are told apart one by one, and of those that are far from all particles.
        let (mut left, mut far) = (k.splat(none), none);
        for first in (0..near.len()).step_by(K::WIDE) {
            let mut apart = [T::of(0.0); LANES];
            if let Some((crowd, ball)) = &crowd {
                apart = crowd.apart(k, first, ball.center);
            }
            for (n, near) in near[first..near.len().min(first + K::WIDE)].iter().enumerate() {
                if let Some((_, ball)) = &crowd {
                    let spare = apart[n] - ball.radius;
                    if spare > ball.margin {
                        far = far.min(spare);
                        continue;
                    }
                }
                let (apart, close) = near.reach.near(k, p, way2);
                let spare = k.sub(apart, k.splat(near.ahead));
                if k.any(k.without(of.free, k.above(spare, found.margin))) {
                    list |= 1 << ((first + n) / found.group);
                } else {
                    left = k.least(spare, left);
                }
                if k.any(k.both(close, of.free)) {
                    p = of.meet(near, p, close);
                    (way2, pushed) = (of.way2(p), k.most(k.squares(k.minus(p, start)), pushed));
                }
            }
        }
        // Pushes can be towards a collider that was taken for far, and make the way longer.
        let pushes = k.any(k.above(pushed, zero));
        let pushed = k.mul(k.sqrt(pushed), k.splat(T::of(1.001)));
        let used = k.add(found.way, k.add(pushed, pushed));
        if crowd.is_none() || !pushes || !k.any(k.without(of.free, k.above(k.splat(far), used))) {
            return (list, k.least(k.splat(far), left), pushed);
        }
        crowd = None;
        k.store(of.now[0], of.at, start[0]);
        k.store(of.now[1], of.at, start[1]);
        k.store(of.now[2], of.at, start[2]);
    }
}

/// A ball around the free particles of a vector, and the largest of their margins.
struct Ball<T> {
    center: V3<T>,
    radius: T,
    margin: T,
}

impl<T: Real> Ball<T> {
    /// Around the one in the middle: neighbours in a vector are neighbours in the sheet.
    #[inline(always)]
    fn around<K: Machine<T>>(of: &Vector<T, K>, p: [K::V; 3], margin: K::V) -> Self {
        let k = of.k;
        let (zero, mut free, mut lanes) = (k.splat(T::of(0.0)), [T::of(0.0); LANES], [[T::of(0.0); LANES]; 3]);
        k.store(&mut free, 0, k.choose(of.free, k.splat(T::of(1.0)), zero));
        let mut middle = 0;
        for (n, is_free) in free[..K::WIDE].iter().enumerate() {
            if *is_free > T::of(0.0) && (n <= K::WIDE / 2 || free[middle] == T::of(0.0)) {
                middle = n;
            }
        }
        k.store(&mut lanes[0], 0, p[0]);
        k.store(&mut lanes[1], 0, p[1]);
        k.store(&mut lanes[2], 0, p[2]);
        let center = [lanes[0][middle], lanes[1][middle], lanes[2][middle]];
        let far = k.mul(k.sqrt(k.squares(k.minus(p, k.splats(center)))), k.splat(T::of(1.001)));
        k.store(&mut lanes[0], 0, k.choose(of.free, far, zero));
        k.store(&mut lanes[1], 0, k.choose(of.free, margin, zero));
        let (mut radius, mut most) = (T::of(0.0), T::of(0.0));
        for (far, margin) in lanes[0].iter().zip(&lanes[1]).take(K::WIDE) {
            // NaN is left out: it is near nothing.
            radius = if *far > radius { *far } else { radius };
            most = if *margin > most { *margin } else { most };
        }
        Ball { center, radius, margin: most }
    }
}

/// Meets all colliders.
#[inline(always)]
fn every<T: Real, K: Machine<T>>(mut of: Vector<T, K>, near: &[Near<T>]) {
    let k = of.k;
    let mut p = of.load();
    let mut way2 = of.way2(p);
    for near in near {
        if let (close, true) = near.reach.touches(k, p, way2, of.free) {
            p = of.meet(near, p, close);
            way2 = of.way2(p);
        }
    }
}

/// Meets the colliders of groups with a bit; returns the squares of how far from where they are particles were pushed.
#[inline(always)]
fn listed<T: Real, K: Machine<T>>(
    of: &mut Vector<T, K>,
    near: &[Near<T>],
    (mut list, group): (u64, usize),
    (start, mut way2): ([K::V; 3], K::V),
) -> K::V {
    let k = of.k;
    let (mut p, mut pushed) = (start, k.splat(T::of(0.0)));
    while list != 0 {
        let first = list.trailing_zeros() as usize * group;
        list &= list - 1;
        for near in &near[first..(first + group).min(near.len())] {
            let (close, meets) = near.reach.touches(k, p, way2, of.free);
            if !meets {
                continue;
            }
            p = of.meet(near, p, close);
            (way2, pushed) = (of.way2(p), k.most(k.squares(k.minus(p, start)), pushed));
        }
    }
    pushed
}
