//! Buffers of cloths that come and go. Those of the other cloths stay where they are, and nothing of them is copied.

use super::arena::Arena;
use super::buffers::ClothBuffers;
use super::frames::Frames;
use super::solids::Solids;
use super::store::Store;
use super::{Gpu, fits};
use crate::error::Result;
use crate::form::Form;
use crate::passes::Pass;
use crate::plan::Plan;
use crate::world::{Left, World};

/// The buffers of a cloth that is being added.
pub struct Coming {
    buffers: Vec<ClothBuffers>,
    arena: Option<Arena>,
    frames: Option<Frames>,
    solids: Option<Solids>,
}

impl Gpu {
    /// Refuses the last cloth of a world if it does not fit the device.
    pub fn refuse(&self, world: &World) -> Result<()> {
        let last = world.scene.cloths.iter().zip(&world.runs).next_back();
        last.map_or(Ok(()), |(cloth, run)| fits(&self.device.limits(), cloth, &run.tethers))
    }

    /// Makes the buffers of the last cloth of a world, which is to come, and compiles the passes of its frames.
    pub fn prepare(&mut self, world: &World, draw_only: bool, recoated: bool) -> Coming {
        let index = world.runs.len() - 1;
        let (store, states) = Store::new(&self.device, world, &[index], draw_only);
        let shares = world.arenas.last().is_some_and(|roster| roster.cloths == [index]);
        if !draw_only {
            for form in Plan::forms(world, index) {
                self.pipelines.fitting(&form);
            }
            if world.scene.cloths[index].particles().iter().any(|p| p.is_pinned()) {
                self.pipelines.get(&Form::from(Pass::Place));
            }
        }
        Coming {
            buffers: states.into_iter().map(|(_, state)| ClothBuffers::new(state, !draw_only)).collect(),
            arena: shares.then(|| Arena::new(&self.device, world, store, &[index])),
            frames: (shares && self.frames.is_none()).then(|| Frames::new(&self.device)),
            solids: recoated.then(|| Solids::new(&self.device, world)),
        }
    }

    /// Takes them in.
    pub fn join(&mut self, world: &World, coming: Coming) {
        let Coming { buffers, arena, frames, solids } = coming;
        self.cloths.extend(buffers);
        self.watch.join();
        self.arenas.extend(arena);
        self.frames = self.frames.take().or(frames);
        // Frames that have been recorded with the last lists of colliders may not have been submitted yet, so these stay as they are.
        if let Some(solids) = solids {
            self.solids = solids;
        }
        self.meet(world);
    }

    /// Drops the buffers of a cloth that has left.
    pub fn leave(&mut self, world: &World, index: usize, left: &Left) {
        self.cloths.remove(index);
        self.watch.leave(index);
        self.boxes.leave(index);
        if let Some((arena, member)) = left.place
            && self.arenas[arena].leave(member)
        {
            self.arenas.remove(arena);
        }
        if left.recoated {
            self.solids = Solids::new(&self.device, world);
            self.meet(world);
        }
    }
}
