//! The colliders that particles of a sheet may touch in a frame, in lists that are carried from step to step.
//!
//! Each block of particles has a list, and each particle the distance that it can move before it touches a collider that is not in the
//! list. Distances allow for the way of each collider up to the end of the frame. A list is rebuilt where a particle moved farther.
//! Colliders that are left out would not have moved the particle, so results are the same bits. Lists cost more than they spare where
//! they hold nearly all colliders: there they are not used for the rest of the frame.

use crate::number::lanes::{LANES, Machine};
use crate::number::real::Real;
use std::sync::atomic::AtomicUsize;

/// The share of tests, one in this many, that lists must spare in a step to be used in the next.
pub const PAYS: usize = 4;

/// Colliders near [`LANES`] neighbouring particles.
#[derive(Clone, Copy)]
pub struct Block<T> {
    /// Where each particle was when the list was made \[m\].
    pub at: [[T; LANES]; 3],
    /// How far \[m\] it can move from there without touching a collider that has no bit; 0 where it is not known.
    pub room: [T; LANES],
    /// A bit for each group of colliders that particles may touch.
    pub listed: u64,
}

impl<T: Real> Block<T> {
    /// Without a list.
    fn none() -> Self {
        Block { at: [[T::of(0.0); LANES]; 3], room: [T::of(0.0); LANES], listed: 0 }
    }

    /// Where particles from a lane on were.
    #[inline(always)]
    pub fn at<K: Machine<T>>(&self, k: K, lane: usize) -> [K::V; 3] {
        [k.load(&self.at[0], lane), k.load(&self.at[1], lane), k.load(&self.at[2], lane)]
    }
}

/// The lists of a sheet.
pub struct Clear<T: Real> {
    /// One for each block of `Sheet::w`.
    blocks: Vec<Block<T>>,
    /// The colliders that they are of, by index.
    of: Vec<usize>,
    /// Whether the lists are of this frame.
    holds: bool,
    /// Whether the last step used lists of the step before.
    used: bool,
    /// Tests that lists spared in it, times [`PAYS`].
    spared: AtomicUsize,
    /// Whether they are used in this frame still.
    pays: bool,
}

impl<T: Real> Default for Clear<T> {
    fn default() -> Self {
        let (blocks, of, spared) = (Vec::new(), Vec::new(), AtomicUsize::new(0));
        Clear { blocks, of, holds: false, used: false, spared, pays: true }
    }
}

impl<T: Real> Clear<T> {
    /// Begins a frame: lists are made again.
    pub fn begin(&mut self) {
        (self.holds, self.pays) = (false, true);
    }

    /// Forgets all lists: in the last step no collider was in reach, or one alone, which is as quickly tested as looked up.
    pub fn forget(&mut self) {
        (self.holds, self.used) = (false, false);
    }

    /// Forgets the lists of a sheet of `len` inverse masses, but keeps their room.
    pub fn skip(&mut self, len: usize) {
        self.forget();
        self.blocks.resize(len / LANES, Block::none());
    }

    /// Whether lists are used.
    pub fn pays(&self) -> bool {
        self.pays
    }

    /// The lists, and where the tests that they spare are counted.
    pub fn parts(&mut self) -> (&mut [Block<T>], &AtomicUsize) {
        (&mut self.blocks, &self.spared)
    }

    /// To be called before the lists are used for a sheet of `len` inverse masses and these colliders, in order, in as many `groups`.
    pub fn prepare(&mut self, len: usize, groups: usize, of: impl Iterator<Item = usize> + Clone) {
        let (none, len) = (Block::none(), len / LANES);
        let spared = std::mem::take(self.spared.get_mut());
        if std::mem::take(&mut self.used) && self.holds {
            self.pays &= spared >= len * groups;
        }
        if self.blocks.len() != len {
            self.blocks = vec![none; len];
        } else if !self.holds || !self.of.iter().copied().eq(of.clone()) {
            self.blocks.fill(none);
        } else {
            self.used = true;
        }
        self.of.clear();
        self.of.extend(of);
        self.holds = true;
    }
}
