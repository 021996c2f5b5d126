//! Actions of users on cloths on the GPU: a few dispatches, recorded before the steps.

use bytemuck::cast_slice;

use super::span::Span;
use super::{Gpu, begin};
use crate::choose::Settings;
use crate::cloth::{Cloth, Rest};
use crate::passes::{Pass, has_levels};
use crate::shaders::{Slot, list, source};
use crate::world::{Action, World};

/// The passes that cut a cloth, but for those of its tethers.
pub(super) fn cuts(cloth: &Cloth, options: &Settings) -> impl Iterator<Item = Pass> + use<> {
    let springs = (!matches!(cloth.rest(), Rest::None)).then_some(Pass::CutSprings);
    let levels = has_levels(cloth, options).then_some(Pass::CutLevels);
    [Some(Pass::Cut), springs, levels].into_iter().flatten()
}

impl Gpu {
    /// Makes room for cuts.
    pub fn open(&mut self, world: &World) {
        let cloths = world.scene.cloths.iter().zip(&world.runs);
        for (buffers, (cloth, run)) in self.cloths.iter_mut().zip(cloths) {
            buffers.open(&self.device, cloth, &run.tethers, &world.control.options);
        }
        self.open_arenas(world);
    }

    /// Makes room for cuts in the lists of arenas with cut cloth that may run whole frames.
    pub(super) fn open_arenas(&mut self, world: &World) {
        let whole = |c: &Cloth| c.is_cut() && world.room.is_some_and(|room| room.holds(c));
        for (n, (arena, roster)) in self.arenas.iter_mut().zip(&world.arenas).enumerate() {
            if world.opens(n) && roster.cloths.iter().any(|c| whole(&world.scene.cloths[*c])) {
                arena.open(&self.device, world, &roster.cloths);
            }
        }
    }

    /// Records copies of the lists that cuts have changed into the lists that whole frames read.
    pub(super) fn mirror(&mut self, world: &World, encoder: &mut wgpu::CommandEncoder) {
        for (arena, roster) in self.arenas.iter().zip(&world.arenas) {
            for (member, &index) in roster.cloths.iter().enumerate() {
                let own = &mut self.cloths[index];
                if own.stale && world.is_fused(index) {
                    let cloth = (&world.scene.cloths[index], world.runs[index].tethers.per_particle);
                    arena.mirror(encoder, cloth, member, own);
                    own.stale = false;
                }
            }
        }
    }

    /// Records what is to be done.
    pub fn act(&mut self, world: &mut World, encoder: &mut wgpu::CommandEncoder) {
        let actions = std::mem::take(&mut world.host.actions);
        world.host.touched |= !actions.is_empty();
        world.host.put |= actions.iter().any(|a| matches!(a, Action::Transform { .. } | Action::Load { .. }));
        for action in &actions {
            match action {
                Action::Cut { corners, spared } => {
                    let mut pass = begin(encoder, "cut");
                    let numbers = self.list("cut", cast_slice(&corners.map(|[x, y, z]| [x, y, z, 0.0])));
                    let cloths = world.scene.cloths.iter().enumerate();
                    for (index, cloth) in cloths.filter(|(index, _)| !spared.contains(index)) {
                        self.before_cut(world, &mut pass, index);
                        for what in cuts(cloth, &world.control.options) {
                            let groups = source(&what.into()).workgroups(cloth);
                            self.once(world, &mut pass, index, what, &[(Slot::Action, &numbers)], groups);
                        }
                        self.after_cut(world, &mut pass, index);
                        self.cloths[index].stale = true;
                    }
                }
                Action::Transform { cloth, chosen, matrix } => {
                    self.forget_surface(*cloth);
                    let mut pass = begin(encoder, "transform");
                    let numbers = self.list("matrix", cast_slice(matrix));
                    let chosen_buffer = self.list("chosen", cast_slice(chosen));
                    let more = [(Slot::Action, &numbers), (Slot::Chosen, &chosen_buffer)];
                    self.once(world, &mut pass, *cloth, Pass::Transform, &more, list(chosen.len()));
                }
                Action::Place { cloth, rows } => {
                    self.forget_surface(*cloth);
                    self.place(&mut begin(encoder, "pins"), *cloth, rows);
                }
                Action::Aim { cloth } => self.aim(world, encoder, *cloth),
                Action::Skin { cloth, from, to, rate } => {
                    self.skin(world, encoder, *cloth, (from.as_deref(), to), *rate);
                }
                Action::Inertia { cloth, numbers } => {
                    let mut pass = begin(encoder, "inertia");
                    let list = self.list("impulse", cast_slice(numbers));
                    let groups = source(&Pass::Inertia.into()).workgroups(&world.scene.cloths[*cloth]);
                    self.once(world, &mut pass, *cloth, Pass::Inertia, &[(Slot::Action, &list)], groups);
                }
                Action::Load { cloth, layout, words } => self.load_words(world, encoder, *cloth, (layout, words)),
            }
        }
        self.mirror(world, encoder);
        self.reindex(world, encoder);
        self.rewrap(world, encoder);
    }

    /// Records a pass whose bindings are not kept.
    pub(super) fn once(
        &mut self,
        world: &World,
        pass: &mut wgpu::ComputePass,
        cloth: usize,
        what: Pass,
        more: &[(Slot, &Span)],
        [x, y, z]: [u32; 3],
    ) {
        let pipeline = self.pipelines.get(&what.into());
        let drawn = [Slot::Now, Slot::Before, Slot::Normals, Slot::Holes];
        let is_own = |slot: Slot| !drawn.contains(&slot) && more.iter().all(|m| m.0 != slot);
        if pipeline.source.bindings.iter().any(|bound| is_own(bound.slot)) {
            self.cloths[cloth].separate(&self.device, world, cloth);
        }
        let group = self.cloths[cloth].bind(&self.device, pipeline, more);
        pass.set_pipeline(&pipeline.pipeline);
        pass.set_bind_group(0, &group, &[]);
        pass.dispatch_workgroups(x, y, z);
    }
}
