//! The hull of two balls: all balls whose centres and radii lie between theirs. A point leaves the ball that is nearest to it by the cone.

use super::{Exit, Solid, add, dot, scale, sub};
use crate::number::real::{Real, V3};

/// A tapered capsule in numbers.
#[derive(Clone, Copy, Debug)]
pub struct Taper<T> {
    pub half: T,
    /// Of the ball in the middle, and how much a ball is larger per metre up.
    pub middle: T,
    pub rate: T,
    /// How much lower than a point beside the axis its ball is, per metre from the axis.
    pub slope: T,
    /// The normal of the cone: across the axis, and along it.
    pub across: T,
    pub along: T,
}

impl<T: Real> Taper<T> {
    /// Of lower radius, half height and upper radius.
    #[inline]
    pub fn new([low, half, high]: V3<T>) -> Self {
        let (length, drop) = (half + half, low - high);
        let side = ((length - drop) * (length + drop)).sqrt();
        let middle = T::of(0.5) * (low + high);
        let (across, along) = (side / length, drop / length);
        Taper { half, middle, rate: -along, slope: drop / side, across, along }
    }

    /// The normal of the cone on the x axis of a solid.
    #[inline]
    pub fn normal(&self, solid: &Solid<T>) -> V3<T> {
        add(scale(solid.side, self.across), scale(solid.up, self.along))
    }
}

/// Out of it from `p`, which lies `d` from its middle; from the axis along the normal of the cone.
#[inline]
pub fn tapered<T: Real>(solid: &Solid<T>, p: V3<T>, d: V3<T>) -> Option<Exit<T>> {
    let taper = Taper::new(solid.size);
    let along = dot(d, solid.up);
    let across = sub(d, scale(solid.up, along));
    let y = (along - dot(across, across).sqrt() * taper.slope).max(-taper.half).min(taper.half);
    let (q, radius) = (sub(d, scale(solid.up, y)), taper.middle + y * taper.rate);
    super::ball(p, q, radius, taper.normal(solid))
}

/// Where a path enters its side, as a share of the path, and the normal there.
pub fn side<T: Real>(o: V3<T>, d: V3<T>, size: V3<T>) -> Option<(T, V3<T>)> {
    let Taper { half, middle, across, along, .. } = Taper::new(size);
    // On the cone, across x distance from the axis = middle - along y. Squared, this is a quadratic equation in the share t.
    let (square, to, by) = (across * across, middle - along * o[1], along * d[1]);
    let a = square * (d[0] * d[0] + d[2] * d[2]) - by * by;
    let b = square * (o[0] * d[0] + o[2] * d[2]) + to * by;
    let c = square * (o[0] * o[0] + o[2] * o[2]) - to * to;
    let under = b * b - a * c;
    if under < T::of(0.0) {
        return None;
    }
    // The root where the path goes in, in a form that holds for any slope of the path.
    let t = c / (under.sqrt() - b);
    let left = to - by * t;
    let at = [o[0] + d[0] * t, o[1] + d[1] * t, o[2] + d[2] * t];
    // Of the mirrored cone `left` is below 0; beyond the ends of the segment the balls are met first.
    let y = at[1] - along * left / square;
    let hits = t >= T::of(0.0) && left > T::of(0.0) && y.abs() <= half;
    let beside = (at[0] * at[0] + at[2] * at[2]).sqrt();
    let n = [at[0] * (across / beside), along, at[2] * (across / beside)];
    hits.then(|| (t, scale(n, T::of(1.0) / dot(n, n).sqrt())))
}
