//! A vector of particles meets a collider: the rule of [`super::meet`], bit for bit.

use super::reach::Reach;
use super::short;
use crate::collider::solid::Solid;
use crate::collider::solid::wide::{Exits, Wide, add, choose, cross, dot, scale, splat, sub};
use crate::cpu::guard::is_sane;
use crate::number::lanes::{LANES, Machine};
use crate::number::real::Real;

/// A row of particles: coordinates of where they are and were, and inverse masses from the first one that meets a collider.
pub struct Lines<'a, 'b, T> {
    pub now: &'a mut [&'b mut [T]; 3],
    pub was: [&'a [T]; 3],
    pub w: &'a [T],
}

/// The particles from `at` on. Those whose way is short leave together, the others that are near one by one.
#[inline(always)]
pub fn meet<T: Real, K: Machine<T>>(
    k: K,
    (solid, reach): (&Solid<T>, &Reach<T>),
    Lines { now, was, w }: Lines<T>,
    (at, near): (usize, K::M),
    dt: T,
) {
    let p = [k.load(now[0], at), k.load(now[1], at), k.load(now[2], at)];
    let b = [k.load(was[0], at), k.load(was[1], at), k.load(was[2], at)];
    let free = k.above(k.load(w, 0), k.splat(T::of(0.0)));
    // Where they would have been before, had the collider always been where it is now.
    let turned = cross(k, splat(k, solid.spin), sub(k, b, splat(k, solid.center)));
    let carried = add(k, splat(k, solid.velocity), turned);
    let path = sub(k, p, add(k, b, scale(k, carried, k.splat(dt))));
    let brief = k.both(free, k.above(k.splat(short(solid)), dot(k, path, path)));
    let Exits { at: out, normal, outside } = solid.exits(k, p);
    let inside = k.without(brief, outside);
    let others = k.both(near, k.without(free, brief));
    if k.any(others) {
        let mut alone = [T::of(0.0); LANES];
        k.store(&mut alone, 0, k.choose(others, k.splat(T::of(1.0)), k.splat(T::of(0.0))));
        one_by_one(solid, reach, (now, was), (at, &alone[..K::WIDE]), dt);
    }
    if k.any(inside) {
        let out = if solid.friction > T::of(0.0) { rub(k, solid, (out, p), normal, b, dt) } else { out };
        let again = solid.exits(k, out);
        let out = choose(k, again.outside, out, again.at);
        for c in 0..3 {
            k.store(now[c], at, k.choose(inside, out[c], k.load(now[c], at)));
        }
    }
}

/// Those of the particles from `at` on that are marked by a one.
#[inline(never)]
fn one_by_one<T: Real>(
    solid: &Solid<T>,
    reach: &Reach<T>,
    (now, was): (&mut [&mut [T]; 3], [&[T]; 3]),
    (at, marked): (usize, &[T]),
    dt: T,
) {
    for n in (0..marked.len()).filter(|n| marked[*n] > T::of(0.0)).map(|n| at + n) {
        let (p, b) = ([now[0][n], now[1][n], now[2][n]], [was[0][n], was[1][n], was[2][n]]);
        if !is_sane(p) || !reach.may(p, b) {
            continue;
        }
        if let Some(out) = super::meet(solid, p, b, dt) {
            (0..3).for_each(|c| now[c][n] = out[c]);
        }
    }
}

/// [`super::rub`] of particles that went from `p` out to `at`.
#[inline(always)]
fn rub<T: Real, K: Machine<T>>(
    k: K,
    solid: &Solid<T>,
    (at, p): (Wide<T, K>, Wide<T, K>),
    n: Wide<T, K>,
    was: Wide<T, K>,
    dt: T,
) -> Wide<T, K> {
    let depth = sub(k, at, p);
    let depth = k.sqrt(dot(k, depth, depth));
    let turned = cross(k, splat(k, solid.spin), sub(k, at, splat(k, solid.center)));
    let surface = add(k, splat(k, solid.velocity), turned);
    let moved = sub(k, sub(k, at, was), scale(k, surface, k.splat(dt)));
    let along = sub(k, moved, scale(k, n, dot(k, moved, n)));
    let far = k.sqrt(dot(k, along, along));
    let most = k.mul(k.splat(solid.friction), depth);
    let slides = sub(k, at, scale(k, along, k.div(most, far)));
    choose(k, k.at_least(most, far), sub(k, at, along), slides)
}
