//! Twin of shaders/contact.wgsl: swept collision with moving colliders, and friction.
//!
//! The rule is [`meet`], for one particle. Most particles go a way that is short beside the collider, where the rule is the
//! way out alone: `wide` does that for a vector of them at a time, with the same bits.

pub mod clear;
mod reach;
mod wide;

use super::colliders::rub;
use super::rows::Threads;
use super::sheet::{Sheet, planes, planes_ref};
use crate::collider::solid::Solid;
use crate::number::lanes::{Machine, Work, widest};
use crate::number::real::{Real, V3, add, cross, dot, scale, sub};
use clear::Clear;
use reach::{Reach, bounds};
use std::sync::atomic::{AtomicUsize, Ordering};

/// Rows that are done in one go.
const TOGETHER: usize = 8;

/// Particles inside a collider, or on its other side, go to its surface. Colliders out of reach of the sheet cost one
/// comparison, those out of reach of a block of particles another, and those that were far in an earlier step of the frame none.
pub fn run<T: Real>(threads: &Threads, sheet: &mut Sheet<T>, clear: &mut Clear<T>, solids: &[Solid<T>], dt: T) {
    let (lowest, highest) = bounds(sheet);
    let near = in_reach((lowest, highest), solids, dt);
    if near.is_empty() {
        clear.forget();
        return;
    }
    clear.prepare(sheet.w.len(), near.iter().map(|(index, ..)| *index));
    let size = |p: V3<T>| p[0].abs().max(p[1].abs()).max(p[2].abs());
    let largest = near.iter().fold(size(lowest).max(size(highest)), |most, (_, _, reach)| most.max(reach.size()));
    let moves = near.iter().map(|(_, _, reach)| reach.moves()).fold(T::of(0.0), T::max);
    // Above all rounding of a distance and of what is taken off it.
    let slack = largest * T::of(1e-5);
    let (half, row) = (sheet.half, sheet.row());
    let (w, before) = (&sheet.w[..], &sheet.before[..]);
    let size = (TOGETHER * row, TOGETHER * 2 * half);
    let takes = clear.pays();
    let (least, spared) = clear.parts();
    threads.chunks2(&mut sheet.now, least, size, |chunk, rows, least| {
        let least = Left { least, takes, spared, moves, slack };
        widest(Rows { rows, left: least, row, half, w, before, first: chunk * TOGETHER, near: &near, dt });
    });
}

/// The colliders that particles in a box can touch, in their order: also those that another one can push them to.
fn in_reach<T: Real>(
    (mut lowest, mut highest): (V3<T>, V3<T>),
    solids: &[Solid<T>],
    dt: T,
) -> Vec<(usize, &Solid<T>, Reach<T>)> {
    let mut all: Vec<_> = solids.iter().enumerate().map(|(k, s)| ((k, s), Reach::new(s, dt), false)).collect();
    loop {
        let mut more = false;
        let (low, high) = (lowest, highest);
        for (_, reach, near) in all.iter_mut().filter(|x| !x.2 && x.1.box_near(low, high)) {
            (*near, more) = (true, true);
            let far = reach.pushes(low, high);
            for c in 0..3 {
                lowest[c] = lowest[c].min(far.0[c]);
                highest[c] = highest[c].max(far.1[c]);
            }
        }
        if !more {
            return all.into_iter().filter(|x| x.2).map(|((k, solid), reach, _)| (k, solid, reach)).collect();
        }
    }
}

/// Rows of a sheet from the row `first` on, and what they can touch.
struct Rows<'a, 'b, T> {
    rows: &'b mut [T],
    left: Left<'b, T>,
    row: usize,
    half: usize,
    w: &'a [T],
    before: &'a [T],
    first: usize,
    near: &'a [(usize, &'a Solid<T>, Reach<T>)],
    dt: T,
}

/// The distances of [`Clear`] of some rows.
struct Left<'a, T> {
    least: &'a mut [T],
    /// Whether they are taken; none is read or written otherwise.
    takes: bool,
    /// Particles that they spared.
    spared: &'a AtomicUsize,
    /// How far \[m\] a point of a collider moves in a step, and what is above all rounding.
    moves: T,
    slack: T,
}

impl<T: Real> Work<T> for Rows<'_, '_, T> {
    #[inline(always)]
    fn run<K: Machine<T>>(self, k: K) {
        let Rows { row, half, left: Left { least, takes, spared, moves, slack }, .. } = self;
        let (more, moves, slack) = (k.splat(T::of(1.001)), k.splat(moves), k.splat(slack));
        let (zero, none) = (k.splat(T::of(0.0)), k.splat(T::of(f64::from(f32::MAX))));
        let mut far = 0;
        for (n, (now, least)) in self.rows.chunks_exact_mut(row).zip(least.chunks_exact_mut(2 * half)).enumerate() {
            let j = self.first + n;
            let was = planes_ref(&self.before[j * row..(j + 1) * row], half);
            let w = &self.w[j * 2 * half..(j + 1) * 2 * half];
            let mut now = planes(now, half);
            for at in (0..2 * half).step_by(K::WIDE) {
                let b = [k.load(was[0], at), k.load(was[1], at), k.load(was[2], at)];
                let mut p = [k.load(now[0], at), k.load(now[1], at), k.load(now[2], at)];
                let mut way2 = k.squares(k.minus(p, b));
                let free = k.above(k.load(w, at), zero);
                if takes {
                    let way = k.mul(k.sqrt(way2), more);
                    let left = k.sub(k.sub(k.load(least, at), way), moves);
                    // A way of NaN, or a distance of it, is looked at. Particles that cannot move are not.
                    if !k.any(k.without(free, k.above(left, k.add(way, slack)))) {
                        k.store(least, at, left);
                        // Padding is far from everything.
                        far += if k.any(free) { K::WIDE } else { 0 };
                        continue;
                    }
                }
                let (mut left, mut moved) = (none, false);
                for (_, solid, reach) in self.near {
                    if !takes && !k.any(k.both(reach.may_be_near(k, p, way2), free)) {
                        continue;
                    }
                    let (apart, near) = reach.near(k, p, way2);
                    left = k.least(apart, left);
                    if !k.any(k.both(near, free)) {
                        continue;
                    }
                    let lines = wide::Lines { now: &mut now, was, w: &w[at..] };
                    wide::meet(k, (solid, reach), lines, (at, near), self.dt);
                    p = [k.load(now[0], at), k.load(now[1], at), k.load(now[2], at)];
                    way2 = k.squares(k.minus(p, b));
                    moved = true;
                }
                if takes {
                    k.store(least, at, if moved { zero } else { left });
                }
            }
        }
        spared.fetch_add(far, Ordering::Relaxed);
    }
}

/// Where a particle that went from `was` to `at` in `dt` is put; none if it meets nothing.
#[inline]
pub fn meet<T: Real>(solid: &Solid<T>, at: V3<T>, was: V3<T>, dt: T) -> Option<V3<T>> {
    // Where it would have been before, had the collider always been where it is now.
    let carried = add(solid.velocity, cross(solid.spin, sub(was, solid.center)));
    let from = add(was, scale(carried, dt));
    let (out, normal) = swept(solid, from, at)?;
    let depth = sub(out, at);
    let out =
        if solid.friction > T::of(0.0) { rub(solid, out, normal, was, dot(depth, depth).sqrt(), dt) } else { out };
    // Sliding along a flat or hollow side can end inside again.
    Some(solid.exit(out).map_or(out, |(at, _)| at))
}

/// The way out of a solid at rest for a particle that went from `from` to `at`.
///
/// After a step far shorter than the solid is thick it is the closest one, which is smooth. After a longer one that could
/// be out of the side or the back: it is by the plane that touches the solid where the path entered, or where it began
/// inside, as resting particles do by rounding.
fn swept<T: Real>(solid: &Solid<T>, from: V3<T>, at: V3<T>) -> Option<(V3<T>, V3<T>)> {
    let path = sub(at, from);
    if dot(path, path) < short(solid) {
        return solid.exit(at);
    }
    let met = solid.exit(from).or_else(|| solid.entry(from, path));
    met.and_then(|(surface, normal)| out_by(at, surface, normal)).or_else(|| solid.exit(at))
}

/// Below this square of a way \[m^2\] a particle leaves a solid by the closest point.
fn short<T: Real>(solid: &Solid<T>) -> T {
    let short = solid.thickness() * T::of(0.25);
    short * short
}

fn out_by<T: Real>(at: V3<T>, surface: V3<T>, normal: V3<T>) -> Option<(V3<T>, V3<T>)> {
    let deep = dot(sub(surface, at), normal);
    (deep > T::of(0.0)).then(|| (add(at, scale(normal, deep)), normal))
}

#[cfg(test)]
mod tests;
