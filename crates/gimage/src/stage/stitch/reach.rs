//! How far the borders of a garment are from its other panels, and the distance up to which they are sewn together.

use rayon::prelude::*;

use super::panel::{Panel, Point};
use crate::base::vec3::distance;

/// A point of a border near another panel.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(super) struct Near {
    /// The nearest other panel.
    pub panel: usize,
    /// How far away its surface is \[m\].
    pub distance: f64,
}

/// The range of estimates, in shares of the diagonal of the garment: 0.6 mm to 7 mm on a garment of 1.5 m.
pub(super) const RANGE: [f64; 2] = [4e-4, 4.5e-3];
/// A point counts against an estimate if its distance is within this factor of it.
const WINDOW: f64 = 1.6;
/// Estimates that are tried, in equal ratios.
const TRIED: usize = 64;
/// Where no two panels are near each other, or no gap is found, the estimate in shares of the diagonal.
const PLAIN: f64 = 1e-3;

/// The diagonal of the box around all panels \[m\].
pub(super) fn diagonal(panels: &[Panel]) -> f64 {
    let (mut low, mut high) = ([f64::INFINITY; 3], [f64::NEG_INFINITY; 3]);
    for panel in panels {
        for c in 0..3 {
            (low[c], high[c]) = (low[c].min(panel.bounds[0][c]), high[c].max(panel.bounds[1][c]));
        }
    }
    if panels.is_empty() { 0.0 } else { distance(low, high) }
}

/// The largest distance that an estimate looks at \[m\].
pub(super) fn farthest(panels: &[Panel]) -> f64 {
    diagonal(panels) * RANGE[1] * WINDOW
}

/// For each point the nearest panel but its own, `own`, that is at most `most` \[m\] away.
pub(super) fn nearest(panels: &[Panel], own: usize, points: &[Point], most: f64) -> Vec<Option<Near>> {
    let near = |point: &Point| {
        let others = panels.iter().enumerate().filter(|(k, _)| *k != own);
        let found = others.filter_map(|(panel, p)| Some(Near { panel, distance: p.within(point.at, most)? }));
        found.min_by(|a, b| a.distance.total_cmp(&b.distance).then(a.panel.cmp(&b.panel)))
    };
    points.par_iter().map(near).collect()
}

/// The distance \[m\] that best separates borders that are sewn to a panel from those that merely pass it: the middle of the
/// widest range of distances that the fewest points have. `distances` are those of border points \[m\].
pub(super) fn estimate(distances: &[f64], diagonal: f64) -> f64 {
    let [low, high] = RANGE.map(|share| share * diagonal);
    if diagonal <= 0.0 || !distances.iter().any(|d| *d <= high) {
        return PLAIN * diagonal;
    }
    let mut sorted = distances.to_vec();
    sorted.sort_by(f64::total_cmp);
    let below = |d: f64| sorted.partition_point(|x| *x < d);
    let tried = |n: usize| low * (high / low).powf(n as f64 / (TRIED - 1) as f64);
    let counts: Vec<usize> = (0..TRIED).map(|n| below(tried(n) * WINDOW) - below(tried(n) / WINDOW)).collect();
    let fewest = counts.iter().copied().min().unwrap_or(0);
    let (mut best, mut from) = (0..0, 0);
    for n in 0..=TRIED {
        if counts.get(n) == Some(&fewest) {
            continue;
        }
        if n - from > best.len() {
            best = from..n;
        }
        from = n + 1;
    }
    (tried(best.start) * tried(best.end.max(1) - 1)).sqrt()
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_estimate_lies_in_the_gap_between_sewn_and_free() {
        // Seams of up to 1 mm, and cloth that passes 6 mm and more away, of a garment of 1.5 m.
        let seams = (0..200).map(|k| 1e-3 * f64::from(k) / 199.0);
        let free = (0..100).map(|k| 6e-3 + 1e-3 * f64::from(k));
        let found = estimate(&seams.chain(free).collect::<Vec<_>>(), 1.5);
        assert!((1.3e-3..5e-3).contains(&found), "{found}");
    }

    #[test]
    fn without_anything_near_the_estimate_is_small() {
        assert_eq!(estimate(&[], 2.0), 2e-3);
        assert_eq!(estimate(&[1.0, 2.0], 2.0), 2e-3);
        assert_eq!(estimate(&[0.0], 0.0), 0.0);
    }
}
