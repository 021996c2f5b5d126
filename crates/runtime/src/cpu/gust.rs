//! Velocity of the air at a point: the wind, its heading turned by value noise. Twin of shaders/part/gust.wgsl.

use crate::number::real::{Real, V3};
use crate::step::Step;

/// Velocity \[m/s\] of the air at `p`.
#[inline]
pub fn air<T: Real>(step: &Step<T>, p: V3<T>) -> V3<T> {
    let q = [0, 1, 2].map(|c| p[c] * step.fineness - step.drift[c]);
    let t = step.turn * noise(q);
    // cos and sin by the tangent of the half angle: no trigonometry, so devices agree.
    let over = T::of(1.0) / (T::of(1.0) + t * t);
    let (cos, sin) = ((T::of(1.0) - t * t) * over, T::of(2.0) * t * over);
    let w = step.wind;
    [cos * w[0] + sin * w[2], w[1], cos * w[2] - sin * w[0]]
}

/// Noise between -1 and 1 that changes smoothly from lattice point to lattice point.
fn noise<T: Real>(q: V3<T>) -> T {
    let base = q.map(T::floor);
    let f = [0, 1, 2].map(|c| q[c] - base[c]);
    let u = f.map(|x| x * x * (T::of(3.0) - T::of(2.0) * x));
    let cell = base.map(|x| x.get() as i32);
    let mix = |a: T, b: T, t: T| a + (b - a) * t;
    let row = |y: i32, z: i32| {
        let at = |x: i32| {
            T::of(f64::from(lattice(cell[0].wrapping_add(x), cell[1].wrapping_add(y), cell[2].wrapping_add(z))))
        };
        mix(at(0), at(1), u[0])
    };
    let sheet = |z: i32| mix(row(0, z), row(1, z), u[1]);
    mix(sheet(0), sheet(1), u[2])
}

/// A number between -1 and 1 for a lattice point; repeats after 1024 cells.
fn lattice(x: i32, y: i32, z: i32) -> f32 {
    let wrap = |k: i32| (k & 1023) as u32;
    let mut h = wrap(x) | (wrap(y) << 10) | (wrap(z) << 20);
    // lowbias32 by C. Wellons: integer, so the same everywhere.
    h = (h ^ (h >> 16)).wrapping_mul(0x7feb_352d);
    h = (h ^ (h >> 15)).wrapping_mul(0x846c_a68b);
    h ^= h >> 16;
    (h >> 8) as f32 * (1.0 / 8_388_608.0) - 1.0
}
