//! Twin of shaders/bounds.wgsl: the box around the particles of a cloth, and how far they have moved.

use super::guard::FARTHEST;
use crate::number::real::{Real, V3, dot, sub, xyz};

/// The box around particles, now and one step before, and their largest displacement.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Extent<T> {
    /// The corner of the smallest coordinates \[m\].
    pub low: V3<T>,
    /// That of the largest.
    pub high: V3<T>,
    /// Square of the longest displacement \[m^2\].
    pub far: T,
}

/// The extent of all particles whose positions are numbers within bounds; none if there are no such particles.
pub fn run<T: Real>(now: &[[T; 4]], before: &[[T; 4]]) -> Option<Extent<T>> {
    let most = T::of(FARTHEST);
    // Comparisons with NaN are false.
    let sane = |p: V3<T>| (p[0].abs() <= most) & (p[1].abs() <= most) & (p[2].abs() <= most);
    let mut extent = Extent { low: [most; 3], high: [-most; 3], far: T::of(0.0) };
    for (p, q) in now.iter().zip(before) {
        let (there, p, q) = (p[3] >= T::of(0.0), xyz(*p), xyz(*q));
        if there && sane(p) && sane(q) {
            let d = sub(p, q);
            extent.low = [0, 1, 2].map(|c| extent.low[c].min(p[c]).min(q[c]));
            extent.high = [0, 1, 2].map(|c| extent.high[c].max(p[c]).max(q[c]));
            extent.far = extent.far.max(dot(d, d));
        }
    }
    (extent.low[0] <= extent.high[0]).then_some(extent)
}

/// The extent in the words that the shader leaves.
pub fn read(words: [u32; 7]) -> Option<Extent<f32>> {
    let number = |word: u32| f32::from_bits(if word >> 31 == 1 { word & 0x7fff_ffff } else { !word });
    let [x, y, z, a, b, c, far] = words;
    // 0 is none.
    (x > 0).then(|| Extent {
        low: [x, y, z].map(|word| -number(word)),
        high: [a, b, c].map(number),
        far: f32::from_bits(far),
    })
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn particles_fill_a_box_now_and_before() {
        let nothing = [f32::NAN, 7.0, 7.0, -1.0];
        let now =
            [[1.0, -2.0, 3.0, 0.5], nothing, [0.0, 5.0, -4.0, 0.0], [f32::NAN, 0.0, 0.0, 1.0], [2e8, 0.0, 0.0, 1.0]];
        let mut before = now;
        (before[0], before[2]) = ([1.0, -2.0, 6.0, 0.5], [0.0, 5.0, -4.0, 0.0]);
        let extent = Extent { low: [0.0, -2.0, -4.0], high: [1.0, 5.0, 6.0], far: 9.0 };
        assert_eq!(run(&now, &before), Some(extent));
        assert_eq!((run(&now[3..], &before[3..]), run::<f64>(&[], &[])), (None, None));
    }

    #[test]
    fn words_of_the_shader_are_ordered_as_numbers() {
        let ordered = |x: f32| if x.is_sign_negative() { !x.to_bits() } else { x.to_bits() | 0x8000_0000 };
        let numbers = [-1e8f32, -2.5, -1e-30, 0.0, 1e-30, 1.0, 1e8];
        assert!(numbers.windows(2).all(|n| ordered(n[0]) < ordered(n[1])) && ordered(-1e8) > 0);
        for x in numbers {
            let key = ordered(x);
            let words = [ordered(-x), key, key, key, ordered(-x), key, 4f32.to_bits()];
            let extent = Extent { low: [x, -x, -x], high: [x, -x, x], far: 4.0 };
            assert_eq!(read(words), Some(extent));
        }
        assert_eq!(read([0; 7]), None);
    }
}
