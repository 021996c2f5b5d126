//! Which passes of a step run together on cloths that are too large for one workgroup: by tiles, each of which a workgroup
//! has in its memory with enough around it that nothing is left to wait for.
//!
//! Every colour of springs reaches a particle farther, or none, so what a tile owns is right after all eight if it has five
//! columns and rows more on every side, which it relaxes too and then drops. Results are those of separate passes, bit for
//! bit, whatever the size of the tiles. Tiles without anything around them, whose origin alternates so that springs across
//! their borders are left to the next origin, would load less, but relax in another order, and one that depends on their size.
//!
//! Bytes that a particle moves in a step of constant rest lengths, without tethers: in separate passes 64 for the
//! integration, 32 for each of eight colours and 48 for contact, 368. A tile reads where particles are and were, 32 bytes for all that it
//! has, and writes 32 for what it owns: 102 on 256 x 256 particles in 16 KiB, 86 on 1,024 x 1,024 in 36 KiB. Bytes beyond 64 are
//! read by neighbours as well, and come out of a cache. Tethers read 8 bytes for each of a particle.

mod order;
mod shape;

pub use order::{Order, order};
pub use shape::TileShape;

use crate::cpu::tile::around;
use crate::passes::{Air, Kinds, Pass, Soft};

/// Consecutive passes of a step in one dispatch, described by the variants compiled into its shader.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash)]
pub struct Tile {
    /// The integration that comes first, if any does.
    pub air: Option<Air>,
    /// Whether that keeps what rounding takes.
    pub exact: bool,
    /// Whether the multipliers of the last step end.
    pub forget: bool,
    /// Whether tethers hold before springs, and after them.
    pub tethers: [bool; 2],
    /// Anchors per particle; 0 where there is no pass of tethers.
    pub slots: u32,
    /// Colours of springs: bit 2 * direction + parity.
    pub colours: u32,
    /// Further rounds of tethers, where there are any, and of springs to the right and down.
    pub polish: u32,
    /// Whether rest lengths come from an image.
    pub image: bool,
    /// Where compliance comes from.
    pub soft: Soft,
    /// Whether multipliers are summed over several relaxations.
    pub again: bool,
    /// Colliders that come last, if they do.
    pub contact: Option<Kinds>,
    /// Sizes.
    pub shape: TileShape,
    /// Threads of a workgroup.
    pub threads: u32,
}

/// Colours in the order in which they run.
const COLOURS: [(u32, u32); 8] = [(2, 0), (2, 1), (3, 0), (3, 1), (0, 0), (0, 1), (1, 0), (1, 1)];

impl Tile {
    /// What makes just these passes, but for sizes; `None` where nothing does.
    fn of(passes: &[Pass]) -> Option<Self> {
        let mut tile = Tile {
            air: None,
            exact: false,
            forget: false,
            tethers: [false; 2],
            slots: 0,
            colours: 0,
            polish: 0,
            image: false,
            soft: Soft::None,
            again: false,
            contact: None,
            shape: TileShape::default(),
            threads: 0,
        };
        for pass in passes {
            match *pass {
                Pass::Integrate(air) => tile.air = Some(air),
                Pass::Advance(air) => (tile.air, tile.exact) = (Some(air), true),
                Pass::Forget => tile.forget = true,
                Pass::Tethers { slots } => {
                    tile.tethers[usize::from(tile.colours > 0 || tile.tethers[0])] = true;
                    tile.slots = slots;
                }
                Pass::Stretch { direction, parity, image, soft, again } => {
                    tile.colours |= 1 << (2 * direction + parity);
                    (tile.image, tile.soft, tile.again) = (image, soft, again);
                    // Those before were not the last ones, but those of a round.
                    tile.tethers[1] = false;
                }
                Pass::Contact(kinds) => tile.contact = Some(kinds),
                _ => return None,
            }
        }
        let structural = passes.iter().find(|p| p.is_structural());
        let rounds = passes.iter().filter(|p| structural == Some(*p)).count();
        tile.polish = rounds.saturating_sub(1) as u32;
        // Sums are a matter of springs.
        (tile.passes() == passes && tile.again >= tile.forget).then_some(tile)
    }

    /// The passes that the shader makes, in its order.
    fn passes(&self) -> Vec<Pass> {
        let Tile { image, soft, again, slots, .. } = *self;
        let tethers = (slots > 0).then_some(Pass::Tethers { slots });
        let spring = |(direction, parity)| Pass::Stretch { direction, parity, image, soft, again };
        let springs: Vec<_> = COLOURS.into_iter().filter(|c| self.has(*c)).map(spring).collect();
        let step = if self.exact { Pass::Advance } else { Pass::Integrate };
        let mut all: Vec<_> = self.air.map(step).into_iter().collect();
        all.extend(self.forget.then_some(Pass::Forget));
        all.extend(tethers.filter(|_| self.tethers[0]));
        all.extend(&springs);
        for _ in 0..self.polish {
            all.extend(tethers);
            all.extend(springs.iter().filter(|p| p.is_structural()));
        }
        all.extend(tethers.filter(|_| self.tethers[1]));
        all.extend(self.contact.map(Pass::Contact));
        all
    }

    fn has(&self, (direction, parity): (u32, u32)) -> bool {
        self.colours >> (2 * direction + parity) & 1 == 1
    }

    /// Columns and rows around a tile, and whether it begins at odd ones.
    fn around(&self) -> ([u32; 2], [u32; 2]) {
        let springs = COLOURS.into_iter().filter(|c| self.has(*c));
        let structural = springs.clone().filter(|c| c.0 < 2);
        let polish = (0..self.polish).flat_map(|_| structural.clone());
        around(&springs.chain(polish).collect::<Vec<_>>())
    }
}
