//! How far particles of a sheet are from all that they can touch, carried from step to step of a frame.
//!
//! Most particles are near no collider for a whole frame. Their distances are taken once; afterwards each step takes off how far the
//! particle and the colliders moved, and colliders are looked at again only where nothing is left. Particles that are left out would
//! not have moved, so results are the same bits. Cloth that moves fast uses its distances up in a step or two: there they cost more
//! than they spare, and are not taken for the rest of the frame.

use crate::number::aligned::Aligned;
use crate::number::real::Real;
use std::sync::atomic::AtomicUsize;

/// The share of particles, one in this many, that distances must spare in a step to be taken in the next.
const PAYS: usize = 4;

/// Distances \[m\] in the layout of `Sheet::w`, each at most that to the reach of any collider.
pub struct Clear<T: Real> {
    /// At most the distance of each particle; 0 where it is not known.
    least: Aligned<T>,
    /// The colliders that they are of, by index.
    of: Vec<usize>,
    /// Whether particles moved only as a step moves them once since the distances were taken.
    holds: bool,
    /// Whether the last step used distances of the step before.
    used: bool,
    /// Particles that they spared in it.
    spared: AtomicUsize,
    /// Whether they are taken in this frame still.
    pays: bool,
}

impl<T: Real> Default for Clear<T> {
    fn default() -> Self {
        let (least, of, spared) = (Aligned::default(), Vec::new(), AtomicUsize::new(0));
        Clear { least, of, holds: false, used: false, spared, pays: true }
    }
}

impl<T: Real> Clear<T> {
    /// Begins a frame: distances are taken again.
    pub fn begin(&mut self) {
        (self.holds, self.pays) = (false, true);
    }

    /// Forgets all distances: particles met colliders in this step already, or in the last step none was in reach.
    pub fn forget(&mut self) {
        self.holds = false;
    }

    /// Whether distances are taken.
    pub fn pays(&self) -> bool {
        self.pays
    }

    /// The distances, and where the particles that they spare are counted.
    pub fn parts(&mut self) -> (&mut [T], &AtomicUsize) {
        (&mut self.least, &self.spared)
    }

    /// To be called before the distances are used for a sheet of `len` inverse masses and these colliders, in order.
    pub fn prepare(&mut self, len: usize, of: impl Iterator<Item = usize> + Clone) {
        let spared = std::mem::take(self.spared.get_mut());
        if std::mem::take(&mut self.used) && self.holds {
            self.pays &= spared * PAYS >= len;
        }
        if self.least.len() != len {
            self.least = Aligned::zeros(len);
        } else if !self.holds || !self.of.iter().copied().eq(of.clone()) {
            self.least.fill(T::of(0.0));
        } else {
            self.used = true;
        }
        self.of.clear();
        self.of.extend(of);
        self.holds = true;
    }
}
