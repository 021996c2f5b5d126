//! Contact of a cloth with itself, between its passes: tiles of particles, the boxes around them, and who may meet whom.

pub mod extents;
pub mod loose;
pub mod others;
pub mod patrol;
pub mod shadow;
#[cfg(test)]
mod tests;
pub mod tiles;

use self::loose::LoosePlaces;
use self::others::OtherList;
use self::patrol::Patrol;
use self::shadow::{Dawn, Shadow};
use self::tiles::{LANES_OF_TILE, Tiles};
use super::drift;
use super::leaves;
use super::partners::{self, TileList};
use super::separate;
use super::tile_pairs::Beside;
use super::touch;
use super::tree::{self, Tree};
use crate::cloth::{Cloth, ContactTier, Kin};
use crate::cpu::rows::Threads;
use crate::cpu::sheet::Sheet;
use crate::memory::Tally;
use crate::number::real::Real;

/// The lists of contact of a cloth.
pub struct Meeting<T: Real> {
    pub tiles: Tiles<T>,
    pub tree: Tree<T>,
    /// One a tile.
    pub lists: Vec<TileList<T>>,
    /// Tiles that may meet, as the last search has found them.
    pub beside: Beside,
    /// Looks for cloth that crosses, of a tier that does not exclude it.
    pub patrol: Option<Patrol>,
    /// Tiles in which a particle has a partner, or is one, in ascending order.
    pub active: Vec<u32>,
    pub kin: Kin,
    /// Particles of other cloths in this frame, and for each tile which list is its, `u32::MAX` for none.
    pub others: Vec<OtherList<T>>,
    pub other_of: Vec<u32>,
    /// Time \[s\] from the beginning of the frame to the end of the step.
    pub elapsed: T,
    shadow: Option<Shadow<T>>,
    /// Particles that may pass others, as cloth crosses there.
    pub loose: LoosePlaces,
    /// \[m\]
    pub distance: T,
    /// Coefficient of friction.
    pub friction: T,
    /// Whether partners have to be searched: the last search no longer holds.
    due: bool,
}

impl<T: Real> Meeting<T> {
    /// That of a cloth with contact.
    pub fn of(cloth: &Cloth, sheets: &[Sheet<T>], thickness: f32) -> Option<Self> {
        let contact = cloth.contact.as_ref()?;
        let kin = Kin::of(cloth);
        let tiles = Tiles::new(cloth, sheets, &kin);
        Some(Meeting {
            tree: Tree::new(&tiles),
            lists: Vec::new(),
            beside: Beside::default(),
            patrol: (contact.tier == ContactTier::Particles).then(Patrol::default),
            active: Vec::new(),
            kin,
            others: Vec::new(),
            other_of: Vec::new(),
            elapsed: T::of(0.0),
            shadow: None,
            loose: LoosePlaces::default(),
            distance: T::of(cloth.contact_distance(thickness).into()),
            friction: T::of(contact.friction.into()),
            due: true,
            tiles,
        })
    }

    /// Numbers that it takes.
    pub fn tally(&self, tally: &mut Tally) {
        self.tiles.tally(tally);
        self.tree.tally(tally);
        tally.state(&self.lists);
        self.beside.tally(tally);
        self.shadow.iter().for_each(|shadow| shadow.tally(tally));
        tally.state(&self.others);
        tally.state(&self.kin.first);
        tally.state(&self.kin.members);
    }

    /// The next search must not rely on the last one.
    pub fn search_again(&mut self) {
        self.due = true;
    }

    /// The same, and the looks for cloth that crosses begin again, as those of a state that is loaded do.
    pub fn forget(&mut self) {
        self.search_again();
        self.patrol.iter_mut().for_each(Patrol::forget);
    }

    /// Begins the looks for cloth that crosses in a frame.
    pub fn begin_patrol(&mut self) {
        self.patrol.iter_mut().for_each(Patrol::begin);
    }

    /// The shadow of the cloth in a frame.
    pub fn shadow(&mut self, dawn: &Dawn<T>) -> Shadow<T> {
        let known = self.shadow.take();
        let mut shadow = known.unwrap_or_else(|| Shadow::new(&self.tiles, self.distance, self.friction));
        shadow.follow(&self.tiles, dawn);
        shadow.loose.clone_from(&self.loose.others);
        shadow
    }

    /// Finds out which particles of other cloths it may meet in a frame; its own shadow is at `own`. Returns the cloths that are asleep and
    /// wake.
    pub fn meet(&mut self, shadows: &[Option<Shadow<T>>], own: usize) -> Vec<usize> {
        let struck = others::run(self, shadows, own);
        self.elapsed = T::of(0.0);
        self.find_active();
        struck
    }

    /// Takes in where those particles are now, in the middle of a frame.
    pub fn follow(&mut self, shadows: &[Option<Shadow<T>>], own: usize) {
        others::follow(self, shadows, own);
        self.elapsed = T::of(0.0);
    }

    /// Keeps the memory of its shadow.
    pub fn keep(&mut self, shadow: Shadow<T>) {
        self.shadow = Some(shadow);
    }

    /// Finds the tiles whose particles may touch others, or be touched.
    pub fn find_active(&mut self) {
        let mut active = vec![false; self.tiles.count()];
        for (tile, list) in self.lists.iter().enumerate().filter(|(_, list)| list.count > 0) {
            active[tile] = true;
            let used = &list.partner[..list.count as usize * LANES_OF_TILE];
            used.iter().for_each(|place| active[*place as usize / LANES_OF_TILE] = true);
        }
        let others = active.iter_mut().zip(&self.other_of).filter(|(_, of)| **of != u32::MAX);
        others.for_each(|(active, _)| *active = true);
        self.active.clear();
        self.active.extend((0..active.len() as u32).filter(|tile| active[*tile as usize]));
    }

    /// Twin of the pass `Leaves`. Boxes are made only where the last ones no longer hold the particles in the next steps.
    pub fn leaves(&mut self, sheets: &[Sheet<T>]) {
        // Lists have shares by inverse masses.
        self.due |= self.tiles.load_all(sheets);
        if self.due || !drift::holds(&self.tree, &self.tiles) {
            // Looks for cloth that crosses compare particles of the same boxes.
            let crossing = |tile: usize| self.tiles.crossing2[tile].sqrt();
            let width = |tile| if self.patrol.is_some() { self.distance.max(crossing(tile)) } else { self.distance };
            leaves::run(&mut self.tree, &self.tiles, self.distance, width);
            self.due = true;
        }
    }

    /// Twin of the pass `Tree`.
    pub fn refit(&mut self) {
        if self.due {
            tree::run(&mut self.tree);
        }
    }

    /// Twin of the pass `Partners`.
    pub fn search(&mut self, threads: &Threads) {
        if std::mem::take(&mut self.due) {
            partners::run(self, threads);
        }
        if let Some(patrol) = &mut self.patrol {
            patrol.look(&self.tiles, &self.beside);
        }
    }

    /// Twin of the pass `Touch`.
    pub fn touch(&mut self, sheets: &[Sheet<T>], threads: &Threads, dt: T) {
        if !self.active.is_empty() {
            touch::run(self, sheets, threads, dt);
        }
    }

    /// Twin of the pass `Separate`.
    pub fn separate(&self, sheets: &mut [Sheet<T>]) {
        separate::run(self, sheets);
    }
}
