//! How the edges of a part of a cloth spread: where they spread little, the part cannot meet itself.
//!
//! Points of the surface that are u columns and v rows apart are joined by a way along edges of cells. If these edges are near two vectors,
//! `right` and `down`, the way is at least as long as the larger of u and v times what is left of the vectors; so are the distances of cells
//! that have no corner in common. Pairs of cells with a common corner are those of [`super::flat`]. A cone of normals would not do: a roll
//! has a narrow cone along its axis.

use super::boxes::Bound;
use super::drift::Way;
use super::surface::Patch;
use crate::number::real::{dot, sub};

/// The edges of the cells of a part.
#[derive(Clone, Copy, Debug)]
pub struct Spread {
    right: Bound,
    down: Bound,
    /// The largest reach of its points \[m\].
    reach: f32,
    /// Whether every cell has two triangles, and all blocks around their corners are even.
    even: bool,
}

impl Spread {
    /// That of no cell.
    pub const NONE: Spread = Spread { right: Bound::NONE, down: Bound::NONE, reach: 0.0, even: true };
    /// That of a cell that may meet others nearby.
    pub const WIDE: Spread = Spread { even: false, ..Spread::NONE };

    /// That of a cell with these corners, upper row first, at both ends of their ways: in between edges are between theirs.
    pub(super) fn of([a, b, c, d]: [Way; 4]) -> Self {
        let edge = |p: &Way, q: &Way| {
            let [begin, end] = [sub(q.from, p.from), sub(q.to, p.to)].map(|way| way.map(|x| x as f32));
            Bound { low: begin, high: begin }.with(&Bound { low: end, high: end })
        };
        let reach = [a, b, c, d].iter().map(|way| way.reach).fold(0.0, f64::max) as f32;
        let right = edge(&a, &b).with(&edge(&c, &d));
        Spread { right, down: edge(&a, &c).with(&edge(&b, &d)), reach, even: true }
    }

    /// That of two parts.
    #[inline]
    pub fn with(&self, other: &Self) -> Self {
        Spread {
            right: self.right.with(&other.right),
            down: self.down.with(&other.down),
            reach: self.reach.max(other.reach),
            even: self.even && other.even,
        }
    }

    /// Whether no two features of the part that share no point can come nearer to one another than `floor` \[m\]: the part is a rectangle of
    /// cells, or two such that share a side or a corner.
    #[inline]
    pub fn is_apart(&self, floor: f32) -> bool {
        if !self.even {
            return false;
        }
        let ((a, off_a), (b, off_b)) = (self.right.ball(), self.down.ball());
        let (long_a, long_b, both) = (dot(a, a).sqrt(), dot(b, b).sqrt(), dot(a, b).abs());
        let off = off_a + off_b;
        let left = (long_a - both / long_a).min(long_b - both / long_b) - off;
        // Comparisons with NaN are false.
        0.999 * left > 2.0 * self.reach + floor
    }
}

/// Whether all blocks around the corners of a cell are even, of those that there are.
pub fn is_even(patch: &Patch, even: &[bool], i: usize, j: usize) -> bool {
    let lines = |at: usize, count: usize| at.max(1)..(at + 2).min(count - 1);
    let row = |n: usize| lines(i, patch.width).all(|m| even[patch.first + n * patch.width + m]);
    patch.width > 2 && patch.height > 2 && lines(j, patch.height).all(row)
}
