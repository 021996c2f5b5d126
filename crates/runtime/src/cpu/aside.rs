//! Twin of shaders/part/aside.wgsl: a way out for springs that have almost no length.
//!
//! Springs push along themselves. A heap of particles in one plane, on one line or at one point can then never leave it, and
//! trembles forever, as its springs cannot all have their lengths there. A push aside too small to be seen is enough, and
//! one by springs to the right is: the others then have a length. So it costs a comparison in every fourth spring.

use crate::number::real::{Real, V3};

/// A spring to the right shorter than this share of its rest length is pushed aside. Cloth that is merely crumpled has none.
pub const SHORT: f64 = 0.1;
/// By at most this share of its rest length along each axis.
pub const ASIDE: f64 = 1e-4;

/// The way of the spring at a texel of its grid, each number within -1..1: it looks random, and is always the same.
///
/// A hash after M. Jarzynski, M. Olano, "Hash Functions for GPU Rendering", JCGT 2020 (PCG).
pub fn way<T: Real>(texel: u32) -> V3<T> {
    let state = texel.wrapping_mul(747_796_405).wrapping_add(2_891_336_453);
    let word = ((state >> ((state >> 28) + 4)) ^ state).wrapping_mul(277_803_737);
    let hash = (word >> 22) ^ word;
    [0, 10, 20].map(|bit| T::of(f64::from((hash >> bit) & 1023) / 512.0 - 1.0))
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn ways_of_neighbours_differ_and_none_is_preferred() {
        let ways: Vec<V3<f64>> = (0..4096).map(way).collect();
        assert!(ways.windows(2).all(|w| (0..3).any(|c| (w[0][c] - w[1][c]).abs() > 1e-2)));
        for c in 0..3 {
            let mean = ways.iter().map(|w| w[c]).sum::<f64>() / 4096.0;
            assert!(mean.abs() < 0.03 && ways.iter().all(|w| (-1.0..1.0).contains(&w[c])), "{mean}");
        }
        // In f32 they are the same numbers.
        assert!((0..4096).all(|k| way::<f32>(k).map(f64::from) == way::<f64>(k)));
    }
}
