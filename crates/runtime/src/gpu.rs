//! The GPU backend: buffers, pipelines and the recording of a frame.

mod actions;
#[cfg(test)]
#[path = "../tests/support/adapter.rs"]
mod adapter;
mod ahead;
mod arena;
mod bounds;
mod buffers;
mod carry;
mod contact;
mod contents;
mod cut_tethers;
mod frames;
mod held;
mod indices;
mod joint;
mod levels;
mod lockstep;
mod lost;
mod mapped;
mod members;
mod pick;
mod pipelines;
mod place;
mod read_back;
mod recording;
mod ring;
mod save;
mod shared;
mod skin;
mod solids;
mod span;
mod staging;
mod store;
mod tangents;
mod timing;
mod turns;
mod upload;
mod uploads;
#[cfg(not(target_family = "wasm"))]
mod wait;
mod watch;
mod worn;
mod wrap;
mod wrap_indices;

pub use ahead::{Ahead, Preparation};
pub use buffers::ClothBuffers;
pub(crate) use carry::Carried;
pub(crate) use lost::{guard, guard_async, is_lost};
pub(crate) use mapped::{block_on, bytes};
pub(crate) use pick::Pending;
pub use read_back::{read_back_async, read_back_picture_async, read_back_u32_async};
pub(crate) use ring::Ring;
pub use span::Span;
pub(crate) use upload::filled;
pub use uploads::UploadCount;
#[cfg(not(target_family = "wasm"))]
pub use wait::{read_back, read_back_picture, read_back_u32};

use bytemuck::{bytes_of, cast_slice};

use crate::cloth::{Cloth, Tethers};
use crate::cpu::body::Body;
use crate::cpu::fabric::partners::MAX_PARTNERS;
use crate::cpu::rows::Threads;
use crate::error::{Error, Result};
use crate::form::Form;
use crate::frame::Frame;
use crate::fused;
use crate::layout::{POSES, StepRow};
use crate::passes::Pass;
use crate::shaders::{PLANE_BYTES, Slot, VERTEX_BYTES};
use crate::world::{Batch, ClothRun, World};
use arena::{Arena, Underway};
use bounds::Boxes;
use carry::Tables;
use frames::Frames;
use joint::Joint;
use lockstep::among_others;
use lost::Pulse;
pub use pipelines::Compiled;
pub(crate) use pipelines::Pipelines;
use recording::Recording;
use solids::Solids;
use store::Store;
use timing::Timing;
pub use timing::{PassTime, device_features};
use uploads::Writer;
use watch::Watch;

/// Why nothing more runs on a device.
#[derive(Clone, Copy)]
enum Failure {
    Lost,
    /// Out of memory.
    Full,
}

/// Where the numbers of a dispatch lie \[bytes\]: those of its step, and its own.
#[derive(Clone, Copy, Default)]
struct Offsets {
    step: u32,
    part: u32,
}

/// Everything on the device.
pub struct Gpu {
    pulse: Pulse,
    /// The failure after which nothing runs on this device; none while it works.
    failure: Option<Failure>,
    device: wgpu::Device,
    writer: Writer,
    pipelines: Pipelines,
    cloths: Vec<ClothBuffers>,
    /// In the order of the world's.
    arenas: Vec<Arena>,
    frames: Frames,
    /// Those of this frame, or of the last one, whose memory the next one uses again.
    batches: Vec<Batch>,
    /// Likewise where these are in the frame.
    underway: Vec<Underway>,
    /// Likewise the numbers of the last dispatch.
    numbers: Vec<u8>,
    /// Likewise the cloths that share no dispatch, and where the numbers of their last steps lie.
    apart: (Vec<usize>, Vec<u32>),
    solids: Solids,
    watch: Watch,
    boxes: Boxes,
    timing: Timing,
    /// Numbers by which motion is carried between the images of cloths.
    tables: Tables,
    /// Cloths that have contact with one another.
    joint: Option<Box<Joint>>,
}

impl Gpu {
    /// Buffers for all cloths; only those for drawing where the CPU steps.
    pub fn new(
        world: &World,
        (device, queue): (&wgpu::Device, &wgpu::Queue),
        pipelines: Pipelines,
        draw_only: bool,
    ) -> Result<Self> {
        for (cloth, run) in world.scene.cloths.iter().zip(&world.runs) {
            fits(&device.limits(), cloth, &run.tethers)?;
        }
        joint::fits(&device.limits(), world)?;
        let (mut states, mut arenas) = (Vec::new(), Vec::new());
        let mut shared = vec![false; world.runs.len()];
        for cloths in world.arenas.iter().map(|roster| &roster.cloths) {
            let (store, spans) = Store::new(device, world, cloths, draw_only);
            states.extend(spans);
            arenas.push(Arena::new(device, world, store, cloths));
            cloths.iter().for_each(|c| shared[*c] = true);
        }
        let alone = (0..shared.len()).filter(|c| !shared[*c]);
        states.extend(alone.flat_map(|cloth| Store::new(device, world, &[cloth], draw_only).1));
        states.sort_by_key(|(cloth, _)| *cloth);
        let mut gpu = Gpu {
            pulse: Pulse::new(device)?,
            failure: None,
            solids: Solids::new(device, world),
            pipelines,
            cloths: states.into_iter().map(|(_, state)| ClothBuffers::new(state, !draw_only)).collect(),
            frames: Frames::new(device),
            batches: Vec::new(),
            underway: Vec::new(),
            numbers: Vec::new(),
            apart: Default::default(),
            arenas,
            device: device.clone(),
            writer: Writer { queue: queue.clone(), count: Default::default() },
            watch: Watch::new(world.scene.cloths.len()),
            boxes: Boxes::default(),
            timing: Timing::default(),
            tables: Tables::default(),
            joint: None,
        };
        gpu.meet(world);
        if !draw_only {
            ahead::frames(world).iter().for_each(|form| _ = gpu.pipelines.get(form));
            for cloth in world.scene.cloths.iter().filter(|c| c.follows_joints()) {
                let pass = cloth.skin().map(|s| Pass::Skin { sets: s.sets as u32, skinning: cloth.skinning });
                pass.iter().for_each(|pass| _ = gpu.pipelines.get(&(*pass).into()));
            }
        }
        Ok(gpu)
    }

    /// Whether the device can go on: an error if it is lost, or a call has failed on it.
    pub fn check(&mut self) -> Result<()> {
        if self.failure.is_none() && self.pulse.is_lost() {
            self.failure = Some(Failure::Lost);
        }
        match self.failure {
            None => Ok(()),
            Some(Failure::Lost) => Err(Error::DeviceLost),
            Some(Failure::Full) => Err(Error::OutOfMemory),
        }
    }

    /// Takes in that a call has failed on the device half-way.
    pub fn fail(&mut self, error: &Error) {
        self.refused();
        match error {
            Error::DeviceLost => self.failure = Some(Failure::Lost),
            Error::OutOfMemory => self.failure = Some(Failure::Full),
            _ => {}
        }
    }

    /// Takes in that a call has failed that changed nothing. Pipelines that it compiled may not work, so they are compiled again.
    pub fn refused(&mut self) {
        self.pipelines.forget();
        self.frames.ring.forget();
    }

    /// Takes in that a call has ended without an error.
    pub fn succeeded(&mut self) {
        self.pipelines.keep();
    }

    /// The device and its queue.
    pub fn handles(&self) -> (&wgpu::Device, &wgpu::Queue) {
        (&self.device, &self.writer.queue)
    }

    /// Its pipelines, for another stepper.
    pub fn share_pipelines(&self) -> Pipelines {
        self.pipelines.share()
    }

    /// The pipelines that are not compiled yet of a world with some rounds of polish, as [`Preparation::new`].
    pub fn prepare_for(&self, later: (World, Vec<u32>), ahead: &[Ahead], cut: bool) -> Preparation {
        Preparation::new(self.pipelines.shared(), later, ahead, cut)
    }

    /// The pipelines compiled so far, and how long that took.
    pub fn compiled(&self) -> Compiled {
        self.pipelines.compiled
    }

    pub fn buffers(&self, cloth: usize) -> Option<&ClothBuffers> {
        self.cloths.get(cloth)
    }

    /// Records `steps` steps of every cloth that is awake and has any, then its normals; after [`Gpu::begin`].
    pub fn record(&mut self, world: &mut World, encoder: &mut wgpu::CommandEncoder, steps: u32) {
        let (mut alone, mut last) = std::mem::take(&mut self.apart);
        alone.clear();
        last.clear();
        alone.extend((0..self.cloths.len()).filter(|c| world.is_apart(*c)));
        self.join_contact(world, encoder);
        world.look_at_starts(steps);
        // Those that meet others come last.
        alone.sort_by_key(|c| self.is_joint(*c));
        for faults in alone.iter().filter_map(|c| self.cloths[*c].faults.as_ref()) {
            encoder.clear_buffer(&faults.buffer, faults.offset, Some(4));
        }
        for (strain, at) in alone.iter().filter_map(|c| self.cloths[*c].strain(false)) {
            encoder.clear_buffer(strain, at, Some(4));
        }
        self.solids.follow(&mut self.frames.ring, encoder);
        self.wear(world, encoder, steps);
        let budget = world.control.options.quality.budget().is_some() && steps > 0;
        let mut timing = std::mem::take(&mut self.timing);
        let mut passes = timing.begin(&self.device, encoder, budget);
        self.record_shared(world, &mut passes, steps);
        for &index in &alone {
            self.cloths[index].separate(&self.device, world, index);
            if !self.is_joint(index) {
                last.push(self.record_steps(world, &mut passes, index, steps));
            }
        }
        let meeting = alone.iter().position(|index| self.is_joint(*index)).unwrap_or(alone.len());
        last.extend(self.record_lockstep(world, &mut passes, &alone[meeting..], steps));
        if alone.iter().any(|c| self.cloths[*c].turned.contains(&true)) {
            let between = passes.between();
            alone.iter().for_each(|c| self.cloths[*c].turn_back(between));
        }
        self.end_shared(&mut passes, steps);
        for (&index, &offset) in alone.iter().zip(&last) {
            let cloth = &world.scene.cloths[index];
            let frame = world.runs[index].schedule.frame.iter();
            let offsets = Offsets { step: offset, ..Offsets::default() };
            frame.for_each(|what| self.run_in(cloth, &mut passes, index, (&Form::Apart(*what), offsets)));
        }
        self.apart = (alone, last);
        let spans = passes.end();
        timing.copy(&self.device, encoder, spans, steps);
        self.timing = timing;
        self.watch(world, encoder, steps);
        (world.host.touched, world.host.put) = (false, false);
        world.control.tick(steps);
        self.record_bounds(world, encoder, &world.without_rest_box());
    }

    /// Records the steps of a cloth; returns where the numbers of the last one lie.
    fn record_steps(&mut self, world: &World, passes: &mut Recording, index: usize, steps: u32) -> u32 {
        self.frames.ring.group();
        let rows = Span { buffer: self.frames.ring.buffer.clone(), offset: 0, size: size_of::<StepRow>() as u64 };
        self.cloths[index].replace(Slot::Step, rows);
        let frame = world.frame(index, steps);
        (0..steps).map(|n| self.record_step(world, passes, index, (&frame, n))).last().unwrap_or(0)
    }

    /// Records one step of a cloth; returns where its numbers lie.
    fn record_step(&mut self, world: &World, passes: &mut Recording, index: usize, (frame, n): (&Frame, u32)) -> u32 {
        let (cloth, order) = (&world.scene.cloths[index], world.order(index));
        // Moving colliders have a new pose once in this number of steps.
        let group = frame.steps.div_ceil(POSES);
        let step = self.frames.ring.place(bytes_of(&StepRow::from(&frame.step(n, n / group * group))));
        let (coarse, meets) = (frame.coarse(n), self.meets(index));
        let mut run = |what: &Form| {
            let what = if meets { among_others(what, n) } else { what };
            self.run_in(cloth, passes, index, (what, Offsets { step, ..Offsets::default() }));
        };
        frame.near(n).iter().chain(frame.gusts(n)).chain(frame.air(n)).for_each(|p| run(&Form::Apart(*p)));
        let whole = order.filter(|_| coarse.is_empty());
        match whole {
            Some(order) => order.first.iter().for_each(&mut run),
            None => frame.schedule.step.iter().chain(coarse).for_each(|p| run(&Form::Apart(*p))),
        }
        for _ in u32::from(whole.is_some())..frame.rounds {
            match order {
                Some(order) => order.relax.iter().for_each(&mut run),
                None => frame.schedule.relax.iter().for_each(|p| run(&Form::Apart(*p))),
            }
        }
        step
    }

    /// Records one pass of a cloth in a frame, with the numbers that lie at some offsets.
    fn run_in(&mut self, cloth: &Cloth, passes: &mut Recording, index: usize, what: (&Form, Offsets)) {
        let shader = if passes.each { self.pipelines.get(what.0).source.stem } else { "" };
        self.run(cloth, passes.pass(shader), index, what);
    }

    /// Records one pass of a cloth, with the numbers that lie at some offsets.
    fn run(&mut self, cloth: &Cloth, pass: &mut wgpu::ComputePass, index: usize, (what, offsets): (&Form, Offsets)) {
        let pipeline = self.pipelines.get(what);
        let buffers = &mut self.cloths[index];
        let group = buffers.group(&self.device, pipeline);
        let bound = |slot: Slot, offset: u32| pipeline.source.binds(slot).then_some(offset);
        // In the order of bindings.
        let offsets = [bound(Slot::Step, offsets.step), bound(Slot::Part, offsets.part)];
        let mut own = [0; 2];
        let count = own.iter_mut().zip(offsets.into_iter().flatten()).map(|(own, offset)| *own = offset).count();
        let [x, y, z] = pipeline.source.workgroups(cloth);
        pass.set_pipeline(&pipeline.pipeline);
        pass.set_bind_group(0, group, &own[..count]);
        pass.dispatch_workgroups(x, y, z);
        buffers.turn(&pipeline.source);
    }

    /// Writes what the CPU made of cloths that are awake into the buffers for drawing.
    pub fn upload(&mut self, bodies: &[Body<f32>], threads: &Threads, runs: &[ClothRun]) {
        let all = bodies.iter().zip(runs).enumerate().filter(|(_, (_, run))| !run.asleep);
        all.for_each(|(cloth, (body, _))| self.upload_one(cloth, body, threads));
    }

    /// The same for one cloth.
    pub fn upload_one(&mut self, cloth: usize, body: &Body<f32>, threads: &Threads) {
        let mut write = |span: &Span, bytes: &[u8]| self.writer.write(&span.buffer, span.offset, bytes);
        let buffers = &self.cloths[cloth];
        write(&buffers.now, cast_slice(body.now()));
        write(&buffers.before, cast_slice(body.before()));
        write(&buffers.normals, cast_slice(body.normals(threads)));
        if let Some(holes) = &buffers.holes {
            write(holes, cast_slice(&body.holes));
        }
    }

    /// Takes in the colliders, which the next frame uploads; new bindings only if their number, or which cloth has which coat, has
    /// changed. `alike`: neither has.
    pub fn set_colliders(&mut self, world: &World, alike: bool) {
        if self.solids.write(&self.device, world, alike) {
            self.meet(world);
        }
    }

    fn meet(&mut self, world: &World) {
        let cloths = self.cloths.iter_mut().enumerate();
        cloths.for_each(|(c, buffers)| buffers.replace(Slot::Solids, self.solids.of(world, c)));
    }
}

/// Errors where a buffer of a cloth is larger than the device allows.
fn fits(limits: &wgpu::Limits, cloth: &Cloth, held: &Tethers) -> Result<()> {
    let (buffer, bound) = (limits.max_buffer_size, limits.max_storage_buffer_binding_size);
    let limit = bound.min(buffer);
    let len = cloth.len() as u64;
    // Passes bind a part of what lasts from frame to frame, but it is one buffer.
    let lasting = if cloth.is_exact() { 32 * fused::room_of(cloth.len()) as u64 } else { 0 };
    let cells = if cloth.membrane().is_some() { 32 * len } else { 0 };
    let tethers = 8 * held.per_particle as u64 * len;
    let sets = cloth.skin().filter(|_| cloth.follows_joints()).map_or(0, |skin| 1 + 2 * skin.sets as u64);
    let surface = cloth.body().map_or([0; 3], |surface| {
        let vertices = surface.vertices() * VERTEX_BYTES.max(32 * (1 + cloth.body_sets()));
        [PLANE_BYTES * cloth.len(), vertices, 4 * surface.words()].map(|bytes| bytes as u64)
    });
    let partners = if cloth.contact.is_some() { 8 * MAX_PARTNERS as u64 * len } else { 0 };
    // No other buffer of a cloth has more bytes per particle.
    let buffers = [
        ("positions", 16 * len, limit),
        ("tethers", tethers, limit),
        ("cells", cells, limit),
        ("partners in contact", partners, limit),
        ("planes at the surface of a body", surface[0], limit),
        ("vertices of the surface of a body", surface[1], limit),
        ("triangles of the surface of a body", surface[2], limit),
        ("influences of joints", 16 * sets * len, limit),
        ("positions of the last good frame", lasting, buffer),
    ];
    for (buffer, need, limit) in buffers {
        if need > limit {
            return Err(Error::Limit { cloth: cloth.name().into(), buffer, need, limit });
        }
    }
    Ok(())
}

/// The limits to request a device with, so that as many cloths as possible run whole frames in one dispatch: those of
/// WebGPU, raised to the workgroup memory, threads and storage buffers of the adapter.
pub fn device_limits(adapter: &wgpu::Adapter) -> wgpu::Limits {
    let have = adapter.limits();
    wgpu::Limits {
        max_compute_workgroup_storage_size: have.max_compute_workgroup_storage_size,
        max_compute_invocations_per_workgroup: have.max_compute_invocations_per_workgroup,
        max_compute_workgroup_size_x: have.max_compute_workgroup_size_x,
        // More than any shader binds is asked of no device.
        max_storage_buffers_per_shader_stage: have.max_storage_buffers_per_shader_stage.min(24),
        max_storage_buffer_binding_size: have.max_storage_buffer_binding_size,
        max_buffer_size: have.max_buffer_size,
        ..wgpu::Limits::default()
    }
}

fn begin<'a>(encoder: &'a mut wgpu::CommandEncoder, label: &str) -> wgpu::ComputePass<'a> {
    encoder.begin_compute_pass(&wgpu::ComputePassDescriptor { label: Some(label), timestamp_writes: None })
}

impl crate::shaders::Source {
    pub(crate) fn binds(&self, slot: Slot) -> bool {
        self.bindings.iter().any(|b| b.slot == slot)
    }
}
