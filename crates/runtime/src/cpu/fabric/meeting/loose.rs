//! Particles that contact does not push away from one another, because cloth crosses there and is being taken apart.

use super::Meeting;
use super::tiles::Tiles;
use crate::cpu::untangle::loose::Loose;
use crate::number::real::Real;

/// Which particles may pass one another, by places; both lists are empty while cloth does not cross.
#[derive(Default)]
pub struct LoosePlaces {
    /// Those that pass loose particles of their own cloth.
    pub own: Vec<bool>,
    /// Those that pass loose particles of other cloths.
    pub others: Vec<bool>,
}

/// Whether the particle of a place is listed.
#[inline]
pub fn is_loose(list: &[bool], place: usize) -> bool {
    list.get(place).is_some_and(|loose| *loose)
}

impl<T: Real> Meeting<T> {
    /// From here on particles are not pushed away from those that they may pass.
    pub fn loosen(&mut self, loose: impl Fn(u32) -> Loose) {
        let of = |texel: &u32| if *texel == u32::MAX { Loose::default() } else { loose(*texel) };
        let all: Vec<Loose> = self.tiles.texel.iter().map(of).collect();
        let list = |is: fn(&Loose) -> bool| if all.iter().any(is) { all.iter().map(is).collect() } else { Vec::new() };
        let own = list(|loose| loose.own);
        // Partners were listed for others.
        self.due |= own != self.loose.own;
        self.loose = LoosePlaces { own, others: list(|loose| loose.others) };
    }

    /// Takes in which particles are near a line along which cloths cross at rest.
    pub fn cross_at_rest(&mut self, is_crossed: impl Fn(u32) -> bool) {
        let Tiles { crossed, texel, .. } = &mut self.tiles;
        *crossed = texel.iter().map(|texel| *texel != u32::MAX && is_crossed(*texel)).collect();
        self.shadow = None;
    }
}
