//! A vector of particles meets a collider: the rule of [`super::meet`], bit for bit.

use super::reach::Reach;
use super::short;
use crate::collider::solid::Solid;
use crate::collider::solid::wide::{Exits, Wide, add, choose, cross, dot, scale, splat, sub};
use crate::cpu::guard::is_sane;
use crate::number::lanes::{LANES, Machine};
use crate::number::real::Real;

/// A row of particles: coordinates of where they are and were, and which of a vector can move.
pub struct Lines<'a, 'b, T: Real, K: Machine<T>> {
    pub now: &'a mut [&'b mut [T]; 3],
    pub was: [&'a [T]; 3],
    pub free: K::M,
}

/// The particles from `at` on, which are at `p`; where they are afterwards. Those whose way is short leave together, the others that are near
/// one by one.
#[inline(always)]
pub fn meet<T: Real, K: Machine<T>>(
    k: K,
    (solid, reach): (&Solid<T>, &Reach<T>),
    Lines { now, was, free }: Lines<T, K>,
    (at, mut p, near): (usize, Wide<T, K>, K::M),
    dt: T,
) -> Wide<T, K> {
    let b = [k.load(was[0], at), k.load(was[1], at), k.load(was[2], at)];
    // From where they would have been before, had the collider always been where it is now.
    let from = moved_by(k, solid, b, dt);
    let path = sub(k, p, from);
    let brief = k.both(free, k.above(k.splat(short(solid)), dot(k, path, path)));
    let out = solid.exits(k, p);
    let inside = k.without(brief, out.outside);
    let others = k.both(near, k.without(free, brief));
    if k.any(others) {
        let mut alone = [T::of(0.0); LANES];
        k.store(&mut alone, 0, k.choose(others, k.splat(T::of(1.0)), k.splat(T::of(0.0))));
        one_by_one(solid, reach, (now, was), (at, &alone[..K::WIDE]), dt);
        p = [k.load(now[0], at), k.load(now[1], at), k.load(now[2], at)];
    }
    if k.any(inside) {
        let out = if solid.friction > T::of(0.0) { rub(k, solid, &out, from) } else { out.at };
        p = choose(k, inside, out, p);
        k.store(now[0], at, p[0]);
        k.store(now[1], at, p[1]);
        k.store(now[2], at, p[2]);
    }
    p
}

/// [`super::moved_by`]; of a collider at rest the products would be zeros.
#[inline(always)]
fn moved_by<T: Real, K: Machine<T>>(k: K, solid: &Solid<T>, p: Wide<T, K>, dt: T) -> Wide<T, K> {
    if solid.still {
        return p;
    }
    let turned = cross(k, splat(k, solid.spin), sub(k, p, splat(k, solid.center)));
    add(k, p, scale(k, add(k, splat(k, solid.velocity), turned), k.splat(dt)))
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

/// [`super::rub`].
#[inline(always)]
fn rub<T: Real, K: Machine<T>>(k: K, solid: &Solid<T>, out: &Exits<T, K>, from: Wide<T, K>) -> Wide<T, K> {
    let (at, n) = (out.at, out.normal);
    let moved = sub(k, at, from);
    let along = sub(k, moved, scale(k, n, dot(k, moved, n)));
    let far = k.sqrt(dot(k, along, along));
    let most = k.mul(k.splat(solid.friction), out.depth);
    let slides = sub(k, at, scale(k, along, k.div(most, far)));
    choose(k, k.at_least(most, far), sub(k, at, along), slides)
}
