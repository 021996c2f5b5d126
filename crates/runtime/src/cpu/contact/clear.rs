//! How far particles of a sheet are from all that they can touch, carried from step to step of a frame.
//!
//! Most particles are near no collider for a whole frame. Their distances are taken once; afterwards each step takes off how far the
//! particle and the colliders moved, and colliders are looked at again only where nothing is left. Particles that are left out would
//! not have moved, so results are the same bits.

use crate::number::aligned::Aligned;
use crate::number::real::Real;

/// Distances \[m\] in the layout of `Sheet::w`, each at most that to the reach of any collider.
pub struct Clear<T: Real> {
    /// At most the distance of each particle; 0 where it is not known.
    pub least: Aligned<T>,
    /// The colliders that they are of, by index.
    of: Vec<usize>,
    /// Whether particles moved only as a step moves them once since the distances were taken.
    holds: bool,
}

impl<T: Real> Default for Clear<T> {
    fn default() -> Self {
        Clear { least: Aligned::default(), of: Vec::new(), holds: false }
    }
}

impl<T: Real> Clear<T> {
    /// Forgets all distances: a frame begins, or particles met colliders in this step already.
    pub fn forget(&mut self) {
        self.holds = false;
    }

    /// To be called before the distances are used for a sheet of `len` inverse masses and these colliders, in order.
    pub fn prepare(&mut self, len: usize, of: impl Iterator<Item = usize> + Clone) {
        if self.least.len() != len {
            self.least = Aligned::zeros(len);
        } else if !self.holds || !self.of.iter().copied().eq(of.clone()) {
            self.least.fill(T::of(0.0));
        }
        self.of.clear();
        self.of.extend(of);
        self.holds = true;
    }
}
