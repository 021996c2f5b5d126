//! Buffers of cloths that come and go. Those of the other cloths stay where they are, and nothing of them is copied.

use bytemuck::cast_slice;

use super::arena::Arena;
use super::buffers::ClothBuffers;
use super::solids::Solids;
use super::store::Store;
use super::{Gpu, fits, joint};
use crate::cpu::start::Start;
use crate::error::Result;
use crate::form::Form;
use crate::passes::Pass;
use crate::plan::Plan;
use crate::shaders::{LISTED, Slot};
use crate::world::{Left, World};

/// The buffers of a cloth that is being added.
pub struct Coming {
    buffers: Vec<ClothBuffers>,
    arena: Option<Arena>,
    /// The arena in which it takes a place, and which.
    place: Option<(usize, u32)>,
    solids: Option<Solids>,
}

impl Gpu {
    /// Refuses the last cloth of a world if it does not fit the device.
    pub fn refuse(&self, world: &World) -> Result<()> {
        let last = world.scene.cloths.iter().zip(&world.runs).next_back();
        last.map_or(Ok(()), |(cloth, run)| fits(&self.device.limits(), cloth, &run.tethers))?;
        joint::fits(&self.device.limits(), world)
    }

    /// Makes the buffers of the last cloth of a world, which is to come, and compiles the passes of its frames.
    pub fn prepare(&mut self, world: &World, draw_only: bool, recoated: bool) -> Coming {
        let index = world.runs.len() - 1;
        let solids = recoated.then(|| Solids::new(&self.device, world));
        if !draw_only {
            self.compile(world, index);
        }
        let roster = world.arenas.iter().zip(0..).find(|(roster, _)| roster.cloths.contains(&index));
        if let Some((roster, arena)) = roster.filter(|(_, arena)| *arena < self.arenas.len()) {
            let member = roster.cloths.iter().position(|cloth| *cloth == index);
            let place = member.map(|member| (arena, roster.slots[member]));
            return Coming { buffers: Vec::new(), arena: None, place, solids };
        }
        let copies = vec![index; 1 + roster.map_or(0, |(roster, _)| roster.spare.len())];
        let (store, states) = Store::new(&self.device, world, &copies, draw_only);
        let arena = roster.map(|_| {
            let mut arena = Arena::new(&self.device, world, store, &copies);
            arena.keep_first();
            arena
        });
        let states = states.into_iter().take(1);
        let buffers = states.map(|(_, state)| ClothBuffers::new(state, !draw_only)).collect();
        Coming { buffers, arena, place: None, solids }
    }

    /// Takes them in. Whether the cloth has taken a place that another has left: then its state is still to be loaded, in the order of frames
    /// that are recorded; what is drawn before is written at once.
    pub fn join(&mut self, world: &World, coming: Coming) -> bool {
        let Coming { buffers, arena, place, solids } = coming;
        let taken = place.and_then(|(arena, slot)| self.arenas.get_mut(arena)?.take(slot));
        let takes = taken.is_some();
        if let (Some(state), Some(cloth)) = (taken, world.scene.cloths.last()) {
            let start = Start::<f32>::new(cloth, &world.control.options, world.control.clock.dt_old);
            let lists = [(&state.now, &start.now), (&state.before, &start.before), (&state.normals, &start.normals)];
            lists.iter().for_each(|(span, list)| self.writer.write(&span.buffer, span.offset, cast_slice(list)));
            if let Some(faults) = state.others.get(&Slot::Faults) {
                self.writer.write(&faults.buffer, faults.offset, &vec![0; faults.size as usize]);
            }
            self.cloths.push(ClothBuffers::new(state, true));
        }
        self.cloths.extend(buffers);
        self.watch.join();
        self.arenas.extend(arena);
        // Frames that have been recorded with the last lists of colliders may not have been submitted yet, so these stay as they are.
        if let Some(solids) = solids {
            self.solids = solids;
        }
        self.meet(world);
        takes
    }

    /// Makes the buffers of cloths whose image is another one now. `left` has what their last images left behind; arenas of the new
    /// ones are the last of the world's.
    pub fn replace(&mut self, world: &World, left: &[Left], draw_only: bool) {
        for (arena, member) in left.iter().filter_map(|l| l.place) {
            if self.arenas[arena].leave(member) {
                self.arenas.remove(arena);
            }
        }
        let mut states = Vec::new();
        for cloths in world.arenas[self.arenas.len()..].iter().map(|roster| &roster.cloths) {
            let (store, spans) = Store::new(&self.device, world, cloths, draw_only);
            states.extend(spans);
            self.arenas.push(Arena::new(&self.device, world, store, cloths));
        }
        let shared: Vec<usize> = states.iter().map(|(cloth, _)| *cloth).collect();
        let alone = left.iter().map(|l| l.index).filter(|cloth| !shared.contains(cloth));
        states.extend(alone.flat_map(|cloth| Store::new(&self.device, world, &[cloth], draw_only).1));
        for (cloth, state) in states {
            let before = std::mem::replace(&mut self.cloths[cloth], ClothBuffers::new(state, !draw_only));
            (self.cloths[cloth].beside, self.cloths[cloth].wrapping) = (before.beside, before.wrapping);
            self.boxes.forget(cloth);
            if !draw_only {
                self.compile(world, cloth);
            }
        }
        self.meet(world);
    }

    /// Compiles the passes of a cloth's frames, and those of its pins.
    fn compile(&mut self, world: &World, cloth: usize) {
        for form in Plan::forms(world, cloth) {
            self.pipelines.fitting(&form);
        }
        if world.scene.cloths[cloth].particles().iter().any(|p| p.is_pinned()) {
            self.pipelines.get(&Form::from(Pass::Place));
        }
    }

    /// Bytes of the lists that are only read, and of what changes.
    pub fn bytes(&self) -> [u64; 2] {
        let mut all: Vec<(bool, &wgpu::Buffer)> = self.arenas.iter().map(|arena| (true, arena.lists())).collect();
        all.extend(self.arenas.iter().filter_map(|arena| arena.nodes()).map(|nodes| (false, nodes)));
        for buffers in &self.cloths {
            all.extend([&buffers.now, &buffers.before, &buffers.normals].map(|span| (false, &span.buffer)));
            let others = buffers.others.iter().filter(|(slot, _)| **slot != Slot::Solids);
            let read = |slot: &Slot| LISTED.iter().any(|(listed, _)| listed == slot);
            all.extend(others.map(|(slot, span)| (read(slot), &span.buffer)));
        }
        let mut seen: Vec<&wgpu::Buffer> = Vec::new();
        let [mut images, mut states] = [0; 2];
        for (read, buffer) in all {
            // Cloths that share a buffer mostly follow one another.
            if !seen.iter().rev().any(|known| *known == buffer) {
                *(if read { &mut images } else { &mut states }) += buffer.size();
                seen.push(buffer);
            }
        }
        let joint = self.joint.as_ref().map_or(0, |joint| joint.bytes());
        [images + self.tables.bytes(), states + joint]
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
