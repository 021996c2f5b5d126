//! Particles that contact does not push, because cloth crosses there and is being taken apart.

use super::Meeting;
use super::tiles::LANES_OF_TILE;
use crate::cpu::untangle::loose::Loose;
use crate::number::real::Real;

/// A tile with such particles, and which these are.
pub struct LooseTile {
    tile: u32,
    lanes: [Loose; LANES_OF_TILE],
}

impl<T: Real> Meeting<T> {
    /// From here on particles are not pushed away from those that they may pass.
    pub fn loosen(&mut self, loose: impl Fn(u32) -> Loose) {
        self.loose.clear();
        for (tile, texels) in self.tiles.texel.chunks_exact(LANES_OF_TILE).enumerate() {
            let of = |texel: u32| if texel == u32::MAX { Loose::default() } else { loose(texel) };
            let lanes: [Loose; LANES_OF_TILE] = std::array::from_fn(|lane| of(texels[lane]));
            if lanes.iter().any(|lane| lane.any()) {
                self.loose.push(LooseTile { tile: tile as u32, lanes });
            }
        }
        self.spare_others();
    }

    /// Drops distances to particles of other cloths; a search finds them again.
    pub(super) fn spare_others(&mut self) {
        for LooseTile { tile, lanes } in &self.loose {
            let index = self.other_of.get(*tile as usize).copied().unwrap_or(u32::MAX);
            for least in self.others.get_mut(index as usize).iter_mut().flat_map(|list| &mut list.least) {
                least.iter_mut().zip(lanes).filter(|(_, lane)| lane.others).for_each(|(x, _)| *x = T::of(0.0));
            }
        }
    }

    /// Drops the pushes of a step on particles that may pass others of their cloth.
    pub(super) fn spare_own(&mut self) {
        for LooseTile { tile, lanes } in &self.loose {
            for change in self.lists.get_mut(*tile as usize).iter_mut().flat_map(|list| &mut list.change) {
                change.iter_mut().zip(lanes).filter(|(_, lane)| lane.own).for_each(|(x, _)| *x = T::of(0.0));
            }
        }
    }

    /// Takes in which particles are near a line along which cloths cross at rest.
    pub fn cross_at_rest(&mut self, is_crossed: impl Fn(u32) -> bool) {
        self.tiles.crossed = self.tiles.texel.iter().map(|texel| *texel != u32::MAX && is_crossed(*texel)).collect();
        self.shadow = None;
    }
}
