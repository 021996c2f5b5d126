//! Ribbons, belts, straps: disks that are many times longer than wide, and where their ends are.
//!
//! A search over a few aspects and a few starts never meets the layout of a ribbon of 1 to 200: its start has to be known to
//! half a width, a thousandth of the loop. The loop itself tells it: folded at the middle of an end, both of its sides lie on each
//! other, one width apart.

use crate::base::vec3::distance;

/// A disk that is longer than the aspects of the search.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(super) struct Strip {
    /// Length : width of the rectangle with its area and the length of its boundary.
    pub(super) aspect: f64,
    /// The part of the loop that is the middle of an end.
    pub(super) end: f64,
}

/// Folds tried around the loop before the best are refined, and how many are.
const FOLDS: (usize, usize) = (512, 4);

/// Pairs of points that a fold is judged by.
const PAIRS: usize = 48;

/// Halvings of the step of a fold: to 1 / 512 / 2^12 of the loop.
const HALVINGS: usize = 12;

/// Largest mean distance of the two sides, in widths: above it the disk is long for another reason, such as a fringe.
const APART: f64 = 2.0;

impl Strip {
    /// The strip that a disk of this area is, if it is longer than `least` times its width. `points` are the loop, closed, in order.
    /// O(n + folds x pairs x log n).
    pub(super) fn of(points: &[[f64; 3]], area: f64, least: f64) -> Option<Self> {
        let mut at = vec![0.0];
        for (k, &p) in points.iter().enumerate() {
            at.push(at[k] + distance(p, points[(k + 1) % points.len()]));
        }
        let around = *at.last()?;
        // w + h = around / 2, w h = area.
        let half = 0.25 * around;
        let root = half * half - area;
        if !(root.is_finite() && root > 0.0 && area > 0.0) {
            return None;
        }
        let (length, width) = (half + root.sqrt(), area / (half + root.sqrt()));
        let aspect = length / width;
        if !(aspect.is_finite() && aspect > least) {
            return None;
        }
        let point = |part: f64| {
            let s = part.rem_euclid(1.0) * around;
            let k = at.partition_point(|&a| a <= s).clamp(1, points.len());
            let (a, b) = (points[k - 1], points[k % points.len()]);
            let t = ((s - at[k - 1]) / (at[k] - at[k - 1]).max(1e-300)).clamp(0.0, 1.0);
            [0, 1, 2].map(|c| a[c] + t * (b[c] - a[c]))
        };
        let apart = |end: f64| {
            let pair = |k: usize| {
                let s = 0.5 * (k as f64 + 0.5) / PAIRS as f64;
                distance(point(end + s), point(end - s))
            };
            (0..PAIRS).map(pair).sum::<f64>() / PAIRS as f64
        };
        // Folded at one end or at the other one, the loop is the same.
        let mut folds: Vec<(f64, f64)> =
            (0..FOLDS.0).map(|k| 0.5 * k as f64 / FOLDS.0 as f64).map(|end| (apart(end), end)).collect();
        folds.sort_by(|a, b| a.0.total_cmp(&b.0).then(a.1.total_cmp(&b.1)));
        folds.truncate(FOLDS.1);
        let mut best = (f64::INFINITY, 0.0);
        for mut fold in folds {
            let mut step = 0.25 / FOLDS.0 as f64;
            for _ in 0..HALVINGS {
                for end in [fold.1 - step, fold.1 + step] {
                    let d = apart(end);
                    if d < fold.0 {
                        fold = (d, end);
                    }
                }
                step *= 0.5;
            }
            if fold.0 < best.0 {
                best = fold;
            }
        }
        (best.0 <= APART * width).then_some(Self { aspect, end: best.1.rem_euclid(1.0) })
    }
}
