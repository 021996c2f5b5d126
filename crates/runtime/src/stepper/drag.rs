//! Dragging cloth by a point of it.

use super::Stepper;
use crate::error::Result;
use crate::handle::{ClothHandle, ClothRef};
use crate::pick::Hit;

/// A triangle of cloth that is held. [`Stepper::release`] lets it go.
#[derive(Clone, Debug, PartialEq)]
pub struct Drag {
    cloth: ClothHandle,
    /// Particle, whether it was pinned before, and where it is from the point that is held \[m\].
    held: [(u32, bool, [f32; 3]); 3],
}

impl Stepper {
    /// Takes hold of the triangle that was hit: its particles are pinned where the hit saw them, until they are
    /// released. Costs what [`Stepper::set_pins`] of three
    /// particles costs. Wakes the cloth. Errors if the cloth was removed or has no particle of this index.
    pub fn grab(&mut self, hit: &Hit) -> Result<Drag> {
        let index = self.world.find(hit.handle.map_or(ClothRef::Index(hit.cloth), ClothRef::Handle))?;
        let cloth = &self.world.scene.cloths[index];
        let point = hit.point();
        let hold = |n: usize| {
            let k = hit.particles[n];
            let pinned = cloth.particles().get(k as usize).is_some_and(|p| p.is_pinned());
            (k, pinned, [0, 1, 2].map(|c| hit.corners[n][c] - point[c]))
        };
        let drag = Drag { cloth: self.world.handles[index], held: [0, 1, 2].map(hold) };
        self.refuse_joined(index, hit.particles)?;
        self.pin(drag.cloth, &hit.particles)?;
        self.drag(&drag, point)?;
        Ok(drag)
    }

    /// Moves the point that is held to `to` \[m\]; its triangle keeps its place around it. Errors on a number that is
    /// not finite, and if the cloth was removed.
    pub fn drag(&mut self, drag: &Drag, to: [f32; 3]) -> Result<()> {
        let at = drag.held.map(|(_, _, offset)| [0, 1, 2].map(|c| to[c] + offset[c]));
        self.set_pins(drag.cloth, &drag.held.map(|(k, _, _)| k), &at)
    }

    /// Lets go: particles that were free before are free again, at rest where they are; pinned ones stay.
    pub fn release(&mut self, drag: Drag) -> Result<()> {
        let were =
            |pinned| drag.held.iter().filter(move |held| held.1 == pinned).map(|held| held.0).collect::<Vec<_>>();
        self.pin(drag.cloth, &were(true))?;
        self.unpin(drag.cloth, &were(false))
    }
}
