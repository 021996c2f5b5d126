//! Tiles of 4 x 4 cells: which boxes of their cells meet, a vector at a time.

use super::boxes::Bound;
use crate::number::lanes::{LANES, Machine, Work};
use crate::number::real::V3;

/// Columns, and rows, of a tile.
pub const SIDE: usize = 4;

/// The boxes of the cells of a tile, in vectors: low corners, then high ones. Cells that a patch does not have meet nothing.
pub type Tile = [[f32; LANES]; 6];

/// Which cells of a tile have boxes that meet a box: 1 or 0 for each.
pub struct MeetsOne<'a> {
    pub bound: &'a Bound,
    pub tile: &'a Tile,
    pub hits: &'a mut [u8; LANES],
}

impl Work<f32> for MeetsOne<'_> {
    #[inline(always)]
    fn run<K: Machine<f32>>(self, _: K) {
        meets(self.bound.low, self.bound.high, self.tile, self.hits);
    }
}

#[inline(always)]
fn meets(low: V3<f32>, high: V3<f32>, tile: &Tile, hits: &mut [u8; LANES]) {
    for n in 0..LANES {
        let x = (tile[0][n] <= high[0]) & (low[0] <= tile[3][n]);
        let y = (tile[1][n] <= high[1]) & (low[1] <= tile[4][n]);
        let z = (tile[2][n] <= high[2]) & (low[2] <= tile[5][n]);
        hits[n] = (x & y & z) as u8;
    }
}

/// The same for each cell of another tile.
pub struct Meets<'a> {
    pub one: &'a Tile,
    pub other: &'a Tile,
    /// Around the cells of `other`.
    pub both: Bound,
    pub hits: &'a mut [[u8; LANES]; LANES],
}

impl Work<f32> for Meets<'_> {
    #[inline(always)]
    fn run<K: Machine<f32>>(self, _: K) {
        let Meets { one, other, both, hits } = self;
        let mut inside = [0; LANES];
        meets(both.low, both.high, one, &mut inside);
        for (n, hits) in hits.iter_mut().enumerate() {
            if inside[n] != 0 {
                meets([one[0][n], one[1][n], one[2][n]], [one[3][n], one[4][n], one[5][n]], other, hits);
            }
        }
    }
}
