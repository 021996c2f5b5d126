//! Texels that the fit moved farther than it can be trusted go back to where they were sampled.

use super::Image;
use crate::base::vec3::distance;

/// Largest move of a texel, in units of the distance to the farthest of its four neighbours as sampled.
const FARTHEST: f64 = 1.5;

/// Puts every texel of `fitted` that lies farther than [`FARTHEST`] from its place in `sampled` back there, all members of
/// a ring together. Returns how many went back. O(texels).
pub(crate) fn restrain(fitted: &mut [[f64; 3]], sampled: &[[f64; 3]], image: &Image<'_>) -> usize {
    let &Image { columns, rows, rings, .. } = image;
    let reach = |k: usize| -> f64 {
        let (i, j) = (k % columns, k / columns);
        let beside = [
            (i > 0).then(|| k - 1),
            (i + 1 < columns).then_some(k + 1),
            (j > 0).then(|| k - columns),
            (j + 1 < rows).then_some(k + columns),
        ];
        beside.into_iter().flatten().map(|n| distance(sampled[k], sampled[n])).fold(0.0, f64::max)
    };
    // A position that is not finite is too far as well.
    let far = |fitted: &[[f64; 3]], k: usize, reach: f64| {
        let moved = distance(fitted[k], sampled[k]);
        !moved.is_finite() || moved > FARTHEST * reach
    };
    let mut reaches: Vec<f64> = (0..fitted.len()).map(reach).collect();
    // Members of a ring are one point: it may move as far as the freest of them.
    for ring in rings {
        let most = ring.iter().map(|&k| reaches[k as usize]).fold(0.0, f64::max);
        ring.iter().for_each(|&k| reaches[k as usize] = most);
    }
    let mut back = 0;
    for k in 0..fitted.len() {
        if far(fitted, k, reaches[k]) {
            fitted[k] = sampled[k];
            back += 1;
        }
    }
    back
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_texel_that_moved_too_far_goes_back_with_its_ring_and_no_other() {
        let sampled: Vec<[f64; 3]> = (0..16).map(|k| [f64::from(k % 4), f64::from(k / 4), 0.0]).collect();
        let rings = [vec![4u32, 7]];
        let rim = [false; 16];
        let image = Image { columns: 4, rows: 4, rings: &rings, rim: &rim };
        let mut sampled = sampled;
        sampled[7] = sampled[4];
        let mut fitted = sampled.clone();
        fitted[5][2] = 1.4;
        fitted[6][2] = 3.1;
        fitted[4][2] = 6.0;
        fitted[7][2] = 6.0;
        fitted[15][0] = f64::NAN;
        assert_eq!(restrain(&mut fitted, &sampled, &image), 4);
        assert_eq!(fitted[5][2], 1.4);
        assert!([6, 4, 7, 15].iter().all(|&k| fitted[k] == sampled[k]));
    }
}
