//! The GPU backend: buffers, pipelines and the recording of a frame.

mod actions;
mod buffers;
pub(crate) mod layout;
mod pick;
mod pipelines;
mod read_back;
mod watch;

pub use buffers::ClothBuffers;
pub(crate) use pick::Pending;
pub(crate) use read_back::read_bytes;
pub use read_back::{read_back, read_back_u32};

use bytemuck::cast_slice;

use crate::cpu::body::Body;
use crate::error::Result;
use crate::shaders::{Slot, source};
use crate::step::Step;
use crate::world::World;
use buffers::{POSES, solids_buffer};
use layout::{SolidRow, StepRow};
use pipelines::Pipelines;
use watch::Watch;

/// Everything on the device.
pub struct Gpu {
    device: wgpu::Device,
    queue: wgpu::Queue,
    pipelines: Pipelines,
    cloths: Vec<ClothBuffers>,
    solids: wgpu::Buffer,
    solid_rows: Vec<SolidRow>,
    watches: Vec<Watch>,
}

impl Gpu {
    /// Buffers for all cloths; only those for drawing where the CPU steps.
    pub fn new(world: &World, device: &wgpu::Device, queue: &wgpu::Queue, draw_only: bool) -> Result<Self> {
        let cloths = world.scene.cloths.iter().zip(&world.tethers).zip(world.bodies());
        let cloths: Result<_> =
            cloths.map(|((cloth, held), body)| ClothBuffers::new(device, (cloth, held), &body, draw_only)).collect();
        let solid_rows: Vec<_> = world.scene.colliders.iter().map(SolidRow::new).collect();
        Ok(Gpu {
            solids: solids_buffer(device, &solid_rows),
            pipelines: Pipelines::default(),
            cloths: cloths?,
            device: device.clone(),
            queue: queue.clone(),
            solid_rows,
            watches: world.scene.cloths.iter().map(|_| Watch::default()).collect(),
        })
    }

    pub fn buffers(&self, cloth: usize) -> Option<&ClothBuffers> {
        self.cloths.get(cloth)
    }

    /// Records `steps` steps of every cloth that is awake and has any, then its normals.
    pub fn record(&mut self, world: &mut World, encoder: &mut wgpu::CommandEncoder, steps: u32) {
        let mut pass =
            encoder.begin_compute_pass(&wgpu::ComputePassDescriptor { label: Some("cloth"), timestamp_writes: None });
        for index in (0..self.cloths.len()).filter(|c| !world.asleep[*c]) {
            let (cloth, plan) = (&world.scene.cloths[index], &world.schedules[index]);
            let buffers = &mut self.cloths[index];
            let queue = &self.queue;
            let offset = |buffers: &mut ClothBuffers, n: u32| {
                let group = steps.div_ceil(POSES);
                let left = world.left(n / group * group, steps);
                buffers.step_offset(queue, StepRow::from(&Step { left, ..world.step(cloth, n == 0) }))
            };
            let mut run = |buffers: &mut ClothBuffers, what, offset: u32| {
                let source = source(what);
                let pipeline = self.pipelines.get(&self.device, what, &source);
                let group = buffers.group(&self.device, pipeline, &source, &self.solids);
                let offsets: &[u32] = if source.binds(Slot::Step) { &[offset] } else { &[] };
                let [x, y, z] = source.workgroups(cloth);
                pass.set_pipeline(&pipeline.pipeline);
                pass.set_bind_group(0, group, offsets);
                pass.dispatch_workgroups(x, y, z);
            };
            for n in 0..steps {
                let offset = offset(buffers, n);
                plan.step.iter().for_each(|what| run(buffers, *what, offset));
                let rounds = 0..world.options.iterations;
                rounds.for_each(|_| plan.relax.iter().for_each(|what| run(buffers, *what, offset)));
            }
            plan.frame.iter().for_each(|what| run(buffers, *what, 0));
        }
        drop(pass);
        self.watch(world, encoder, steps);
        (0..steps).for_each(|_| world.clock.tick());
    }

    /// Writes what the CPU made into the buffers for drawing.
    pub fn upload(&self, bodies: &[Body<f32>], asleep: &[bool]) {
        for ((buffers, body), asleep) in self.cloths.iter().zip(bodies).zip(asleep) {
            if !asleep {
                self.queue.write_buffer(&buffers.now, 0, cast_slice(body.now()));
                self.queue.write_buffer(&buffers.before, 0, cast_slice(body.before()));
                self.queue.write_buffer(&buffers.normals, 0, cast_slice(&body.normals));
                if let Some(holes) = &buffers.holes {
                    self.queue.write_buffer(holes, 0, cast_slice(&body.holes));
                }
            }
        }
    }

    /// Uploads the colliders; new bindings only if their number has changed.
    pub fn set_colliders(&mut self, world: &World) {
        let rows: Vec<_> = world.scene.colliders.iter().map(SolidRow::new).collect();
        if rows.len() == self.solid_rows.len() {
            self.queue.write_buffer(&self.solids, 0, cast_slice(&rows));
        } else {
            self.solids = solids_buffer(&self.device, &rows);
            self.cloths.iter_mut().for_each(ClothBuffers::forget_colliders);
        }
        self.solid_rows = rows;
    }

    pub fn set_inverse_mass(&self, cloth: usize, k: usize, w: f32) {
        let at = k as u64 * 16 + 12;
        self.queue.write_buffer(&self.cloths[cloth].now, at, cast_slice(&[w]));
        self.queue.write_buffer(&self.cloths[cloth].before, at, cast_slice(&[w]));
    }

    pub fn set_position(&self, cloth: usize, k: usize, at: [f32; 3]) {
        self.queue.write_buffer(&self.cloths[cloth].now, k as u64 * 16, cast_slice(&at));
        self.queue.write_buffer(&self.cloths[cloth].before, k as u64 * 16, cast_slice(&at));
    }
}

impl crate::shaders::Source {
    fn binds(&self, slot: Slot) -> bool {
        self.bindings.iter().any(|b| b.slot == slot)
    }
}
