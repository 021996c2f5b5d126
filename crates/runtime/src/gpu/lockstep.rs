//! Steps of cloths that have contact with one another: each makes a step before any makes the next one.

use bytemuck::cast_slice;

use super::joint::Joint;
use super::recording::Recording;
use super::span::Span;
use super::{Gpu, Offsets};
use crate::form::Form;
use crate::frame::Frame;
use crate::layout::StepRow;
use crate::passes::{FOLLOW_STEPS, MEETING_STEPS, Pass};
use crate::shaders::{Slot, list};
use crate::world::World;

/// Speed that nothing has \[m/s\]: contact wakes no cloth that is awake.
const NO_SPEED: f32 = 1e15;

/// The push of contact in a step, by the steps since other cloths were seen last.
static TOUCH: [Form; FOLLOW_STEPS as usize] =
    [Form::Apart(Pass::Touch { others: 1 }), Form::Apart(Pass::Touch { others: 2 })];

/// The form that runs in place of `form` in step `n`, for cloth that meets others.
pub(super) fn among_others(form: &Form, n: u32) -> &Form {
    match form {
        Form::Apart(Pass::Touch { .. }) => &TOUCH[(n % FOLLOW_STEPS) as usize],
        other => other,
    }
}

impl Gpu {
    /// Follows which cloths have contact with one another, and hands them what they share; to be called as a frame begins.
    pub(super) fn join_contact(&mut self, world: &World, encoder: &mut wgpu::CommandEncoder) {
        self.joint = Joint::follow(self.joint.take(), &self.device, world);
        let Some(joint) = &mut self.joint else { return };
        joint.put |= world.host.put;
        joint.touched |= world.host.touched;
        let numbers = &self.frames.ring.buffer;
        for (member, cloth) in joint.cloths.iter().enumerate() {
            joint.share(member, &mut self.cloths[*cloth], numbers);
        }
        let sleeps = joint.cloths.iter().any(|c| world.runs[*c].asleep);
        let struck = joint.struck(0).filter(|_| sleeps).map(|(buffer, _)| buffer);
        struck.into_iter().chain(joint.counts()).for_each(|buffer| encoder.clear_buffer(buffer, 0, None));
    }

    /// Whether a cloth touches others.
    pub(super) fn meets(&self, cloth: usize) -> bool {
        self.joint.as_ref().is_some_and(|joint| joint.meets() && joint.cloths.contains(&cloth))
    }

    /// Whether a cloth makes each step together with others.
    pub(super) fn is_joint(&self, cloth: usize) -> bool {
        self.joint.as_ref().is_some_and(|joint| joint.cloths.contains(&cloth))
    }

    /// Records the steps of cloths that are awake; where the numbers of the last one lie for each.
    pub(super) fn record_lockstep(
        &mut self,
        world: &World,
        passes: &mut Recording,
        cloths: &[usize],
        steps: u32,
    ) -> Vec<u32> {
        let mut last = vec![0; cloths.len()];
        if cloths.is_empty() {
            return last;
        }
        self.begin_safe(world, passes);
        let frames: Vec<Frame> = cloths.iter().map(|cloth| world.frame(*cloth, steps)).collect();
        let rows = Span { buffer: self.frames.ring.buffer.clone(), offset: 0, size: size_of::<StepRow>() as u64 };
        cloths.iter().for_each(|cloth| self.cloths[*cloth].replace(Slot::Step, rows.clone()));
        for n in 0..steps {
            self.meet_others(world, passes, n, steps);
            self.frames.ring.group();
            for ((cloth, frame), last) in cloths.iter().zip(&frames).zip(&mut last) {
                *last = self.record_step(world, passes, *cloth, (frame, n));
            }
            self.hold_back(world, passes);
        }
        last
    }

    /// Records that cloths take in, before step `n`, where others are, and what they may meet until they do so again.
    fn meet_others(&mut self, world: &World, passes: &mut Recording, n: u32, steps: u32) {
        let Some(mut joint) = self.joint.take() else { return };
        if joint.meets() && n.is_multiple_of(FOLLOW_STEPS) {
            let mut sleeps = false;
            for member in 0..joint.cloths.len() {
                let cloth = joint.cloths[member];
                let asleep = world.runs[cloth].asleep;
                sleeps |= asleep;
                if asleep && joint.still[member] {
                    continue;
                }
                joint.still[member] = asleep;
                self.cast_shadow(world, passes, cloth, n);
            }
            if n.is_multiple_of(MEETING_STEPS) {
                // Where some is asleep, boxes are those of a whole frame, so that it wakes in time.
                let ahead = if sleeps && n == 0 { steps } else { MEETING_STEPS.min(steps - n) };
                self.search_others(world, passes, &mut joint, ahead);
            }
        }
        self.joint = Some(joint);
    }

    /// Records that other cloths see a cloth as it is before step `n`.
    fn cast_shadow(&mut self, world: &World, passes: &mut Recording, cloth: usize, n: u32) {
        let numbers = if world.runs[cloth].asleep {
            let speed = world.control.options.sleep.map_or(NO_SPEED, |sleep| sleep.speed as f32);
            [0.0, speed, 0.0, 0.0]
        } else {
            [world.numbers(cloth)[usize::from(n > 0)].rate as f32, NO_SPEED, 0.0, 0.0]
        };
        let offsets = Offsets { part: self.frames.ring.place(cast_slice(&numbers)), ..Offsets::default() };
        self.run_in(&world.scene.cloths[cloth], passes, cloth, (&Pass::Shadow.into(), offsets));
    }

    /// Records the search for particles of other cloths that particles may meet in some steps.
    fn search_others(&mut self, world: &World, passes: &mut Recording, joint: &mut Joint, ahead: u32) {
        let length = (f64::from(ahead) * world.control.clock.dt) as f32;
        let part = self.frames.ring.place(cast_slice(&[length, 0.0, 0.0, 0.0]));
        let tiles = joint.layout.tiles;
        for (what, groups) in [(Pass::Extents, list(tiles)), (Pass::Tree, [1; 3]), (Pass::Others, list(16 * tiles))] {
            self.run_joint(passes, joint, (what, part), groups);
        }
    }

    /// Records a pass of all cloths together.
    pub(super) fn run_joint(
        &mut self,
        passes: &mut Recording,
        joint: &mut Joint,
        (what, part): (Pass, u32),
        [x, y, z]: [u32; 3],
    ) {
        let pipeline = self.pipelines.get(&what.into());
        let group = joint.group(&self.device, pipeline, &self.frames.ring.buffer);
        let offsets: &[u32] = if pipeline.source.binds(Slot::Part) { &[part] } else { &[] };
        let pass = passes.pass(pipeline.source.stem);
        pass.set_pipeline(&pipeline.pipeline);
        pass.set_bind_group(0, group, offsets);
        pass.dispatch_workgroups(x, y, z);
    }
}
