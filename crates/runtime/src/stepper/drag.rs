//! Dragging cloth by a point of it.

use super::Stepper;
use crate::error::Result;
use crate::pick::Hit;

/// A triangle of cloth that is held. [`Stepper::release`] lets it go.
#[derive(Clone, Debug, PartialEq)]
pub struct Drag {
    cloth: usize,
    /// Particle, whether it was pinned before, and where it is from the point that is held \[m\].
    held: [(usize, bool, [f32; 3]); 3],
}

impl Stepper {
    /// Takes hold of the triangle that was hit: its particles are pinned where the hit saw them, until they are
    /// released. Costs six small uploads, more on a seam. Wakes the cloth. Errors where there is no such particle.
    pub fn grab(&mut self, hit: &Hit) -> Result<Drag> {
        let cloth = self.world.cloth(hit.cloth)?;
        let point = hit.point();
        let hold = |n: usize| {
            let k = hit.particles[n] as usize;
            let pinned = cloth.particles().get(k).is_some_and(|p| p.is_pinned());
            (k, pinned, [0, 1, 2].map(|c| hit.corners[n][c] - point[c]))
        };
        let drag = Drag { cloth: hit.cloth, held: [0, 1, 2].map(hold) };
        for (k, _, _) in drag.held {
            self.set_pinned(drag.cloth, k, true)?;
        }
        self.drag(&drag, point)?;
        Ok(drag)
    }

    /// Moves the point that is held to `to` \[m\]; its triangle keeps its place around it. Errors on a number that is
    /// not finite.
    pub fn drag(&mut self, drag: &Drag, to: [f32; 3]) -> Result<()> {
        for (k, _, offset) in drag.held {
            self.set_position(drag.cloth, k, [0, 1, 2].map(|c| to[c] + offset[c]))?;
        }
        Ok(())
    }

    /// Lets go: particles that were free before are free again, at rest where they are; pinned ones stay.
    pub fn release(&mut self, drag: Drag) -> Result<()> {
        for (k, pinned, _) in drag.held {
            self.set_pinned(drag.cloth, k, pinned)?;
        }
        Ok(())
    }
}
