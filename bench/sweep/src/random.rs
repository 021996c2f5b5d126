//! A seeded generator of random numbers: SplitMix64 (Steele, Lea, Flood 2014).

/// The same seed gives the same numbers on every machine.
#[derive(Clone, Debug)]
pub struct Random(u64);

impl Random {
    /// Numbers for item `item` of a run with this seed: independent of every other item.
    pub fn new(seed: u64, item: u64) -> Self {
        let mut out = Self(seed ^ item.wrapping_mul(0xD1B5_4A32_D192_ED03));
        out.next();
        out
    }

    /// 64 random bits.
    pub fn next(&mut self) -> u64 {
        self.0 = self.0.wrapping_add(0x9E37_79B9_7F4A_7C15);
        let mut z = self.0;
        z = (z ^ (z >> 30)).wrapping_mul(0xBF58_476D_1CE4_E5B9);
        z = (z ^ (z >> 27)).wrapping_mul(0x94D0_49BB_1331_11EB);
        z ^ (z >> 31)
    }

    /// A number in 0..1.
    pub fn unit(&mut self) -> f64 {
        (self.next() >> 11) as f64 / (1u64 << 53) as f64
    }

    /// A number in `low..high`.
    pub fn within(&mut self, low: f64, high: f64) -> f64 {
        low + (high - low) * self.unit()
    }

    /// A number in `low..high`, both above 0, evenly spread in its logarithm.
    pub fn log(&mut self, low: f64, high: f64) -> f64 {
        low * (high / low).powf(self.unit())
    }

    /// A whole number in `0..n`; 0 where `n` is 0.
    pub fn below(&mut self, n: usize) -> usize {
        (self.next() % n.max(1) as u64) as usize
    }

    /// True with probability `p`.
    pub fn chance(&mut self, p: f64) -> bool {
        self.unit() < p
    }

    /// A point in the cube from -1 to 1.
    pub fn point(&mut self) -> [f64; 3] {
        [0; 3].map(|_| self.within(-1.0, 1.0))
    }

    /// A direction, evenly spread over the unit sphere.
    pub fn direction(&mut self) -> [f64; 3] {
        let (z, a) = (self.within(-1.0, 1.0), self.within(0.0, std::f64::consts::TAU));
        let r = (1.0 - z * z).max(0.0).sqrt();
        [r * a.cos(), r * a.sin(), z]
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn items_differ_and_repeat() {
        let draw = |seed, item| Random::new(seed, item).next();
        assert_eq!(draw(1, 5), draw(1, 5));
        assert_ne!(draw(1, 5), draw(1, 6));
        assert_ne!(draw(1, 5), draw(2, 5));
    }

    #[test]
    fn numbers_stay_within_their_ranges() {
        let mut r = Random::new(3, 0);
        for _ in 0..1000 {
            assert!((0.0..1.0).contains(&r.unit()) && r.below(7) < 7 && (1e-3..=1e3).contains(&r.log(1e-3, 1e3)));
            assert!((r.direction().iter().map(|x| x * x).sum::<f64>() - 1.0).abs() < 1e-12);
        }
        assert_eq!(r.below(0), 0);
    }
}
