//! Points spread evenly over a surface, the same ones for any number of threads: sample `i` depends on nothing but the
//! seed and `i`.

use crate::base::vec3::{add, cross, norm, scale, sub};

/// Area-uniform stratified samples of some triangles.
pub(crate) struct Sampler<'a> {
    corners: &'a [[[f64; 3]; 3]],
    cumulative: Vec<f64>,
    count: usize,
    seed: u64,
}

impl<'a> Sampler<'a> {
    pub(crate) fn new(corners: &'a [[[f64; 3]; 3]], count: usize, seed: u64) -> Self {
        let mut sum = 0.0;
        let cumulative = corners
            .iter()
            .map(|&[a, b, c]| {
                sum += 0.5 * norm(cross(sub(b, a), sub(c, a)));
                sum
            })
            .collect();
        Self { corners, cumulative, count, seed }
    }

    /// The area of all triangles.
    pub(crate) fn area(&self) -> f64 {
        self.cumulative.last().copied().unwrap_or(0.0)
    }

    /// Sample `i`: a point of the `i`-th of `count` equal shares of the area, and its triangle. There must be a triangle.
    pub(crate) fn at(&self, i: usize) -> ([f64; 3], usize) {
        let [x, u, v] = [0, 1, 2].map(|k| unit(self.seed, 3 * i as u64 + k));
        let target = (i as f64 + x) / self.count as f64 * self.area();
        // "Not greater" passes over triangles without an area.
        let t = self.cumulative.partition_point(|&c| c <= target).min(self.corners.len() - 1);
        let s = u.sqrt();
        let [a, b, c] = self.corners[t];
        (add(add(scale(a, 1.0 - s), scale(b, s * (1.0 - v))), scale(c, s * v)), t)
    }
}

/// The `n`-th number of a sequence in 0..1: SplitMix64 (Steele, Lea and Flood 2014), read at any place.
fn unit(seed: u64, n: u64) -> f64 {
    let step = 0x9e37_79b9_7f4a_7c15u64;
    let mut z = mix(seed).wrapping_add(step.wrapping_mul(n.wrapping_add(1)));
    z = mix(z);
    (z >> 11) as f64 / (1u64 << 53) as f64
}

fn mix(mut z: u64) -> u64 {
    z = (z ^ (z >> 30)).wrapping_mul(0xbf58_476d_1ce4_e5b9);
    z = (z ^ (z >> 27)).wrapping_mul(0x94d0_49bb_1331_11eb);
    z ^ (z >> 31)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn samples_fall_by_area_and_pass_over_slivers() {
        let flat = |x: f64, w: f64| [[x, 0.0, 0.0], [x + w, 0.0, 0.0], [x, 1.0, 0.0]];
        let corners = [flat(0.0, 0.0), flat(0.0, 3.0), flat(3.0, 0.0), flat(5.0, 1.0), flat(9.0, 0.0)];
        let s = Sampler::new(&corners, 1000, 7);
        let mut hits = [0; 5];
        let mut mean = [0.0; 3];
        for i in 0..1000 {
            let (p, t) = s.at(i);
            hits[t] += 1;
            if t == 1 {
                mean = add(mean, p);
            }
        }
        assert_eq!(hits, [0, 750, 0, 250, 0]);
        assert!((mean[0] / 750.0 - 1.0).abs() < 0.05 && (mean[1] / 750.0 - 1.0 / 3.0).abs() < 0.02);
    }
}
