//! The frames of cloths that share dispatches.

use super::arena::Underway;
use super::recording::Recording;
use super::turns::turned;
use super::{Frames, Gpu, frames};
use crate::form::Form;
use crate::shaders::Slot;
use crate::tile::Sequence;
use crate::world::{Batch, Share, World};

impl Gpu {
    /// Records the whole frames of cloths that share dispatches, and the steps of those that share dispatches step by step.
    pub(super) fn record_shared(&mut self, world: &World, passes: &mut Recording, steps: u32) {
        let batches = std::mem::take(&mut self.batches);
        self.arrange(world, &batches, passes, steps);
        for (n, batch) in batches.iter().enumerate() {
            match &batch.share {
                Share::Whole { .. } => self.record_whole(n, batch, passes, steps),
                Share::Steps { sequence, hold, .. } => {
                    let options = &world.control.options;
                    let count = [steps, options.iterations, *hold, options.pyramid];
                    self.record_batch((n, batch), sequence, passes, count);
                }
            }
        }
        self.batches = batches;
    }

    /// Decides where the jobs and the numbers of all batches lie, and records that these lie there.
    fn arrange(&mut self, world: &World, batches: &[Batch], passes: &mut Recording, steps: u32) {
        self.underway.clear();
        let frames = &mut self.frames;
        let any = |batch: &Batch| world.frame(world.arenas[batch.arena].cloths[batch.members[0]], steps);
        let most = batches.iter().map(|b| b.parts(steps)).max();
        frames.make_room(&self.device, most.unwrap_or(0));
        for of_arena in batches.chunk_by(|a, b| a.arena == b.arena) {
            let arena = of_arena[0].arena;
            self.arenas[arena].follow(world, &world.arenas[arena].cloths, of_arena, (&mut frames.ring, passes));
        }
        let (mut arena, mut first_job) = (0, 0);
        for (place, batch) in batches.iter().enumerate() {
            if batch.arena != arena {
                (arena, first_job) = (batch.arena, 0);
            }
            let (most, solids, grids) = match &batch.share {
                Share::Whole { most, solids, .. } => (*most, *solids, 0),
                Share::Steps { extent, .. } => (steps, 0, extent.grids),
            };
            frames::numbers(&any(batch), most, solids, &mut self.numbers);
            let offset = frames.ring.place(&self.numbers);
            self.underway.push(Underway { place, jobs: [first_job, grids], offset, turned: [false; 4] });
            first_job += batch.members.len() as u32;
        }
    }

    /// Records whole frames, a workgroup a cloth.
    fn record_whole(&mut self, n: usize, batch: &Batch, passes: &mut Recording, steps: u32) {
        let Share::Whole { fused, solids, .. } = &batch.share else { return };
        let (pipeline, of) = (self.pipelines.fitting(&Form::Whole(fused.clone())), &self.underway[n]);
        let buffers = (&self.solids.buffer, &self.frames);
        let group = self.arenas[batch.arena].group(&self.device, (fused, *solids), of.jobs[0], pipeline, buffers);
        let pass = passes.pass(pipeline.source.stem);
        pass.set_pipeline(&pipeline.pipeline);
        for part in 0..batch.parts(steps) {
            pass.set_bind_group(0, group, &[of.offset, Frames::whole(part)]);
            pass.dispatch_workgroups(batch.members.len() as u32, 1, 1);
        }
    }

    /// Records the steps of a batch, as [`Sequence::forms`] counts them.
    fn record_batch(
        &mut self,
        batch: (usize, &Batch),
        sequence: &Sequence,
        passes: &mut Recording,
        [steps, rounds, hold, pyramid]: [u32; 4],
    ) {
        let begins = |n: u32| {
            let rare = !sequence.coarse.is_empty() && n.is_multiple_of(pyramid.max(1));
            if rare { &sequence.coarse } else { &sequence.first }
        };
        // The first dispatch of the frame clears the counters, if it can.
        let first = sequence.gusts.iter().chain(&sequence.air).chain(begins(0)).next();
        let clears = first.is_some_and(|form| self.pipelines.get(form).source.binds(Slot::Faults));
        if steps == 0 || !clears {
            self.arenas[batch.1.arena].clear_faults(&batch.1.members, passes.between());
        }
        for n in 0..steps {
            let mut part = Frames::begins(n);
            let mut run = |gpu: &mut Gpu, form: &Form| {
                gpu.run_batch(batch, passes, (form, part));
                part = Frames::within(n);
            };
            if n == 0 {
                sequence.gusts.iter().for_each(|form| run(self, form));
            }
            if n % hold.max(1) == 0 {
                sequence.air.iter().for_each(|form| run(self, form));
            }
            begins(n).iter().for_each(|form| run(self, form));
            for _ in 1..rounds {
                sequence.relax.iter().for_each(|form| run(self, form));
            }
        }
    }

    /// Records what follows the last step, behind all steps of all cloths: positions may have to be copied before.
    pub(super) fn end_shared(&mut self, passes: &mut Recording, steps: u32) {
        let batches = std::mem::take(&mut self.batches);
        for (of, batch) in self.underway.iter_mut().zip(&batches).filter(|(of, _)| of.turned[..3].contains(&true)) {
            self.arenas[batch.arena].turn_back(&batch.members, of.turned, passes.between());
            of.turned = [false; 4];
        }
        let part = if steps > 0 { Frames::within(steps - 1) } else { Frames::IDLE };
        for (n, batch) in batches.iter().enumerate() {
            if let Share::Steps { sequence, .. } = &batch.share {
                sequence.last.iter().for_each(|form| self.run_batch((n, batch), passes, (form, part)));
            }
        }
        self.batches = batches;
    }

    /// Records a dispatch of a batch, with the numbers of a part of the frame.
    fn run_batch(&mut self, (n, batch): (usize, &Batch), passes: &mut Recording, (form, part): (&Form, u32)) {
        let Share::Steps { extent, .. } = &batch.share else { return };
        let (pipeline, of) = (self.pipelines.get(form), &mut self.underway[n]);
        let buffers = (&self.solids.buffer, &self.frames);
        let group = self.arenas[batch.arena].step_group(&self.device, of, pipeline, buffers);
        let [x, y, z] = pipeline.source.workgroups_of(extent, batch.members.len() as u32);
        let pass = passes.pass(pipeline.source.stem);
        pass.set_pipeline(&pipeline.pipeline);
        pass.set_bind_group(0, group, &[of.offset, part]);
        pass.dispatch_workgroups(x, y, z);
        of.turned = turned(of.turned, &pipeline.source);
    }
}
