//! Bytes that a step by tiles moves.

use super::shape::loads;
use crate::form::{Tile, TileSpan};
use crate::passes::Pass;
use crate::shaders::{Slot, Stages, stages};

/// Bytes of four numbers: a position with its inverse mass, a remainder, multipliers.
const FOUR: f64 = 16.0;
/// Bytes of a position alone.
const THREE: f64 = 12.0;
/// Bytes of an anchor and its distance.
const TETHER: f64 = 8.0;

impl Tile {
    /// Bytes that one dispatch reads and writes for each particle of grids with these columns and rows, in the middle of a frame: positions,
    /// previous positions, remainders, multipliers, images of rest lengths, tethers, limits and backstops. A list that several tiles
    /// read counts once for each of them, though a cache may have it. Constants, colliders and seams do not count.
    pub fn traffic(&self, grids: &[[u32; 2]]) -> f64 {
        let particles: u64 = grids.iter().map(|[w, h]| u64::from(*w) * u64::from(*h)).sum();
        let all = loads(&self.shape, grids) as f64 / particles.max(1) as f64;
        let Stages { tail, arrive, middle, leave } = stages(&self.passes);
        let first = if self.span == TileSpan::Ahead { 1.0 } else { all };
        let lists = [(tail, all), (arrive, first), (middle, all), (leave, 1.0)];
        // Bytes of a list that are read for each particle that the tile owns.
        let reads = |slot: Slot| {
            let most = |list: &[Pass]| list.iter().map(|pass| read(pass, slot)).fold(0.0, f64::max);
            lists.iter().map(|(list, count)| count * most(list)).fold(0.0, f64::max)
        };
        let once = [Slot::Rest, Slot::Tethers, Slot::Targets, Slot::Backs].map(reads);
        let changed = [Slot::Before, Slot::Lost, Slot::Sums].map(|slot| match (slot, reads(slot)) {
            (_, 0.0) => 0.0,
            // Multipliers of the last step end where this one begins.
            (Slot::Sums, _) if self.forgets() => FOUR,
            (Slot::Before, bytes) if self.span != TileSpan::Part => THREE / FOUR * (bytes + FOUR),
            (_, bytes) => bytes + FOUR,
        });
        FOUR * (all + 1.0) + once.iter().chain(&changed).sum::<f64>()
    }
}

/// Bytes of a list that a pass reads for a particle.
fn read(pass: &Pass, slot: Slot) -> f64 {
    let moving = |moves: bool| if moves { 2.0 * FOUR } else { FOUR };
    match (slot, pass) {
        (Slot::Before, Pass::Integrate(_) | Pass::IntegrateExact(_)) | (Slot::Lost, Pass::IntegrateExact(_)) => FOUR,
        (Slot::Sums, Pass::Stretch { again: true, .. }) => FOUR,
        (Slot::Rest, Pass::Stretch { image: true, .. } | Pass::Polish { image: true, .. }) => FOUR,
        (Slot::Tethers, Pass::Tethers { slots }) => TETHER * f64::from(*slots),
        (Slot::Targets, Pass::Limit { moves }) | (Slot::Backs, Pass::Backstop { moves }) => moving(*moves),
        _ => 0.0,
    }
}
