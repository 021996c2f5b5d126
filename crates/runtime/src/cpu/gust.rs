//! Velocity of the air at a point: the wind, its heading turned by value noise. Twin of shaders/part/gust.wgsl.

use crate::number::lanes::Machine;
use crate::number::noise::{LastCell, noise, noises};
use crate::number::real::{Real, V3};
use crate::step::Step;

/// Velocity \[m/s\] of the air at `p`.
#[inline]
pub fn air<T: Real>(step: &Step<T>, last: &mut LastCell<T>, p: V3<T>) -> V3<T> {
    if step.turn == T::of(0.0) {
        return step.wind;
    }
    let q = [0, 1, 2].map(|c| p[c] * step.fineness - step.drift[c]);
    let t = step.turn * noise(last, q);
    // cos and sin by the tangent of the half angle: no trigonometry, so devices agree.
    let over = T::of(1.0) / (T::of(1.0) + t * t);
    let (cos, sin) = ((T::of(1.0) - t * t) * over, T::of(2.0) * t * over);
    let w = step.wind;
    [cos * w[0] + sin * w[2], w[1], cos * w[2] - sin * w[0]]
}

/// The same at a vector of points, with the same bits.
#[inline(always)]
pub fn airs<T: Real, K: Machine<T>>(k: K, step: &Step<T>, last: &mut LastCell<T>, p: [K::V; 3]) -> [K::V; 3] {
    let w = k.splats(step.wind);
    if step.turn == T::of(0.0) {
        return w;
    }
    let (one, fineness) = (k.splat(T::of(1.0)), k.splat(step.fineness));
    let q = k.minus(k.times(p, fineness), k.splats(step.drift));
    let t = k.mul(k.splat(step.turn), noises(k, last, q));
    let square = k.mul(t, t);
    let over = k.div(one, k.add(one, square));
    let cos = k.mul(k.sub(one, square), over);
    let sin = k.mul(k.mul(k.splat(T::of(2.0)), t), over);
    [k.add(k.mul(cos, w[0]), k.mul(sin, w[2])), w[1], k.sub(k.mul(cos, w[2]), k.mul(sin, w[0]))]
}
