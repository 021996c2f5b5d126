//! Dragging cloth by a point of it.

use super::Stepper;
use crate::cloth::Cloth;
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
        let of = &self.world.scene.cloths[index];
        let points = drag.held.map(|(k, pinned, _)| (first_of(of, k), pinned));
        points.into_iter().for_each(|(point, pinned)| self.world.runs[index].grabs.grab(point, pinned));
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

    /// Lets go: particles that were free before are free again, at rest where they are; pinned ones stay, and those that another drag holds.
    pub fn release(&mut self, drag: Drag) -> Result<()> {
        let index = self.world.find(drag.cloth.into())?;
        let of = &self.world.scene.cloths[index];
        let points = drag.held.map(|(k, pinned, _)| (k, first_of(of, k), pinned));
        let (mut kept, mut freed) = (Vec::new(), Vec::new());
        for (k, point, pinned) in points {
            let stays = self.world.runs[index].grabs.release(point, pinned);
            if stays { &mut kept } else { &mut freed }.push(k);
        }
        self.pin(drag.cloth, &kept)?;
        self.unpin(drag.cloth, &freed)
    }
}

/// The first particle of a point.
fn first_of(cloth: &Cloth, k: u32) -> u32 {
    cloth.ring_of(k).and_then(|ring| ring.iter().min().copied()).unwrap_or(k)
}
