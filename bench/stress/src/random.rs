//! Numbers that look random and are the same in every run.

/// A generator: splitmix64, after G. Steele, D. Lea, C. Flood, OOPSLA 2014.
pub struct Random(pub u64);

impl Random {
    /// Evenly from 0 to 1.
    pub fn unit(&mut self) -> f64 {
        self.0 = self.0.wrapping_add(0x9e37_79b9_7f4a_7c15);
        let mut z = self.0;
        z = (z ^ (z >> 30)).wrapping_mul(0xbf58_476d_1ce4_e5b9);
        z = (z ^ (z >> 27)).wrapping_mul(0x94d0_49bb_1331_11eb);
        ((z ^ (z >> 31)) >> 11) as f64 / (1u64 << 53) as f64
    }

    /// A point in a cube from -half to half.
    pub fn point(&mut self, half: f64) -> [f32; 3] {
        [0; 3].map(|_| (half * (2.0 * self.unit() - 1.0)) as f32)
    }
}
