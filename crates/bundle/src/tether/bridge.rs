//! Stitches as paths from piece to piece.

use super::SpringGrid;
use super::front::length;
use crate::stitch::{Place, Stitch};

/// A stitch as the paths between its particle and the corners of its quad.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Bridge {
    /// Bundle-wide index of the particle.
    pub particle: u32,
    /// Bundle-wide indices of the corners, as [`Place::corners`].
    pub corners: [u32; 4],
    /// Distance of each corner \[m\] along its grid to the point of the stitch.
    pub inner: [f64; 4],
    /// Length of the thread \[m\].
    pub thread: f64,
    /// Rest lengths \[m\] between the corners, in the order of [`PAIRS`]; 0 for no spring.
    pub(super) sides: [f64; 6],
}

/// Pairs of corners that a spring joins: top, left, right, bottom, down-right, up-right.
pub(super) const PAIRS: [(usize, usize); 6] = [(0, 1), (0, 2), (1, 3), (2, 3), (0, 3), (2, 1)];

impl Bridge {
    /// Length \[m\] of the path from a corner, 0 to 3, over the point of the stitch to its particle.
    pub fn length(&self, corner: usize) -> f64 {
        self.inner[corner] + self.thread
    }
}

/// Mean lengths of the sides to the right and down. Springs of sides are shared with the quads beside it and may be gone with those; then they
/// follow from the down-right diagonal, as in a rectangle.
fn lengths(sides: &[f64; 6]) -> [f64; 2] {
    let mean = |a: f64, b: f64| if a > 0.0 && b > 0.0 { 0.5 * (a + b) } else { a.max(b) };
    let (right, down) = (mean(sides[0], sides[3]), mean(sides[1], sides[2]));
    let other = |side: f64| (sides[4].powi(2) - side.powi(2)).max(0.0).sqrt();
    match (right > 0.0, down > 0.0) {
        (true, true) => [right, down],
        (true, false) => [right, other(right)],
        (false, true) => [other(down), down],
        (false, false) => [sides[4] * std::f64::consts::FRAC_1_SQRT_2; 2],
    }
}

/// The stitches that lead to a quad that is whole (its down-right diagonal has a spring), in their order.
///
/// The point of a stitch is placed by the rest lengths of its quad, which is taken for a parallelogram of the mean sides: at rest lengths
/// of a parallelogram, distances are exact. O(n) time for n stitches.
pub fn bridges(grids: &[SpringGrid<'_>], stitches: &[Stitch]) -> Vec<Bridge> {
    let firsts: Vec<u32> = (grids.iter())
        .scan(0, |sum, g| {
            let first: u32 = *sum;
            *sum = first.saturating_add(g.width.saturating_mul(g.height));
            Some(first)
        })
        .collect();
    let bridge = |s: &Stitch| {
        let (grid, first) = (grids.get(s.piece as usize)?, *firsts.get(s.piece as usize)?);
        if grid.width < 2 || grid.height < 2 {
            return None;
        }
        let place = Place::of(grid.width, grid.height, s.at);
        let corners = place.corners(grid.width);
        let rest = |corner: usize, kind| length(grid, corners[corner] as usize, kind);
        let sides = [rest(0, 0), rest(0, 1), rest(1, 1), rest(2, 0), rest(0, 2), rest(2, 3)];
        if sides[4] == 0.0 || !(s.distance >= 0.0 && s.distance.is_finite()) {
            return None;
        }
        let [right, down] = lengths(&sides);
        // The product of the two sides as vectors, from both diagonals or from one.
        let product = if sides[5] > 0.0 {
            0.25 * (sides[4].powi(2) - sides[5].powi(2))
        } else {
            0.5 * (sides[4].powi(2) - right.powi(2) - down.powi(2))
        };
        let product = product.clamp(-right * down, right * down);
        let [x, y] = place.inner.map(f64::from);
        let far = |x: f64, y: f64| ((x * right).powi(2) + 2.0 * x * y * product + (y * down).powi(2)).max(0.0).sqrt();
        let inner = [far(x, y), far(1.0 - x, -y), far(-x, 1.0 - y), far(1.0 - x, 1.0 - y)];
        let corners = corners.map(|k| first.saturating_add(k));
        Some(Bridge { particle: s.particle, corners, inner, thread: f64::from(s.distance), sides })
    };
    stitches.iter().filter_map(bridge).collect()
}
