//! The buffers of a cloth.

use std::collections::HashMap;

use bytemuck::{Pod, bytes_of, cast_slice};
use wgpu::util::{BufferInitDescriptor, DeviceExt};
use wgpu::{Buffer, BufferUsages};

use crate::cloth::{Cloth, Compliance, Rest};
use crate::cpu::tethers;
use crate::cpu::body::Body;
use crate::error::{Error, Result};
use crate::gpu::layout::{GridRow, SolidRow, StepRow};
use crate::gpu::pipelines::Pipeline;
use crate::options::{Options, Solver};
use crate::shaders::{Bound, Slot, Source};

/// Distance of the numbers of two steps: the largest alignment that a device may ask for.
const STEP_STRIDE: u32 = 256;
/// A frame takes up to two, or [`POSES`] where colliders move; so many can be recorded before the first submission.
const STEPS: u32 = 1024;
/// Steps of a frame are told apart by moving colliders in so many groups.
pub(super) const POSES: u32 = 128;

/// What a vertex shader reads of a cloth: arrays of vec4<f32>, a particle each, in buffers for storage and vertices.
pub struct ClothBuffers {
    /// Positions \[m\] now; w is 1/mass, 0 for pinned, -1 for no particle.
    pub now: Buffer,
    /// Positions one step before. A vertex lies at `mix(before, now, fraction)`.
    pub before: Buffer,
    /// Unit normals at `now`, 0 where there is none; w is their weight.
    pub normals: Buffer,
    step: Option<Buffer>,
    others: HashMap<Slot, Buffer>,
    groups: HashMap<Vec<Bound>, wgpu::BindGroup>,
    last: Option<StepRow>,
    cursor: u32,
}

impl ClothBuffers {
    /// Uploads a cloth. Errors where a buffer is larger than the device allows.
    pub(super) fn new(device: &wgpu::Device, cloth: &Cloth, body: &Body<f32>, options: &Options, draw_only: bool) -> Result<Self> {
        let limits = device.limits();
        let limit = limits.max_storage_buffer_binding_size.min(limits.max_buffer_size);
        let need = cloth.len() as u64 * 16;
        if need > limit {
            return Err(Error::Limit { cloth: cloth.name().into(), buffer: "positions", need, limit });
        }
        let list =
            |label, data: &[[f32; 4]]| upload(device, label, data, BufferUsages::VERTEX | BufferUsages::COPY_SRC);
        let mut buffers = ClothBuffers {
            now: list("now", body.now()),
            before: list("before", body.before()),
            normals: list("normals", &body.normals),
            step: None,
            others: HashMap::new(),
            groups: HashMap::new(),
            last: None,
            cursor: 0,
        };
        if !draw_only {
            buffers.for_stepping(device, cloth, options);
        }
        Ok(buffers)
    }

    fn for_stepping(&mut self, device: &wgpu::Device, cloth: &Cloth, options: &Options) {
        self.step = Some(device.create_buffer(&wgpu::BufferDescriptor {
            label: Some("step"),
            size: u64::from(STEP_STRIDE * STEPS),
            usage: BufferUsages::UNIFORM | BufferUsages::COPY_DST,
            mapped_at_creation: false,
        }));
        let none = BufferUsages::empty();
        let constant = |g: usize| if let Rest::Constant(r) = cloth.rest() { r[g] } else { [0.0; 4] };
        let rows = cloth.grids().iter().enumerate();
        let rows: Vec<_> = rows
            .map(|(g, grid)| GridRow {
                first: grid.first,
                width: grid.width,
                height: grid.height,
                soft: if let Compliance::Constant(c) = cloth.compliance { c } else { 0.0 },
                rest: constant(g),
            })
            .collect();
        self.others.insert(Slot::Grids, upload(device, "grids", &rows, none));
        if let Rest::Image(rest) = cloth.rest() {
            self.others.insert(Slot::Rest, upload(device, "rest", rest, none));
        }
        if let Compliance::Image(soft) = &cloth.compliance {
            self.others.insert(Slot::Soft, upload(device, "soft", soft, none));
        }
        if options.solver == Solver::Xpbd && options.tethers && cloth.any_pinned() {
            let held = cloth.tethers(tethers::MOST);
            let rows: Vec<_> = held.anchors.iter().map(|a| [a.particle, a.distance.to_bits()]).collect();
            self.others.insert(Slot::Tethers, upload(device, "tethers", &rows, none));
        }
        if cloth.ring_count() > 0 {
            let (starts, members) = cloth.rings();
            self.others.insert(Slot::Starts, upload(device, "starts", starts, none));
            self.others.insert(Slot::Members, upload(device, "members", members, none));
        }
    }

    /// Where the numbers of a step lie; they are written only if they differ from the last ones.
    pub(super) fn step_offset(&mut self, queue: &wgpu::Queue, row: StepRow) -> u32 {
        if self.last != Some(row) {
            self.cursor = (self.cursor + 1) % STEPS;
            self.last = Some(row);
            if let Some(step) = &self.step {
                queue.write_buffer(step, u64::from(self.cursor * STEP_STRIDE), bytes_of(&row));
            }
        }
        self.cursor * STEP_STRIDE
    }

    /// The bindings of a shader, made once.
    pub(super) fn group(
        &mut self,
        device: &wgpu::Device,
        pipeline: &Pipeline,
        source: &Source,
        solids: &Buffer,
    ) -> &wgpu::BindGroup {
        // Only cloth in wind that acts on triangles, or with several relaxations of soft springs, has these.
        for slot in [Slot::Field, Slot::Sums] {
            if source.bindings.iter().any(|b| b.slot == slot) {
                let (usage, size) = (BufferUsages::STORAGE, self.now.size());
                let wish = wgpu::BufferDescriptor { label: Some(slot.name()), size, usage, mapped_at_creation: false };
                self.others.entry(slot).or_insert_with(|| device.create_buffer(&wish));
            }
        }
        let ClothBuffers { now, before, normals, step, others, groups, .. } = self;
        groups.entry(source.bindings.clone()).or_insert_with(|| {
            let buffer = |slot| match slot {
                Slot::Now => Some(&*now),
                Slot::Before => Some(&*before),
                Slot::Normals => Some(&*normals),
                Slot::Step => step.as_ref(),
                Slot::Solids => Some(solids),
                other => others.get(&other),
            };
            let resource = |slot: Slot, buffer| {
                let size =
                    (slot == Slot::Step).then(|| std::num::NonZeroU64::new(size_of::<StepRow>() as u64)).flatten();
                wgpu::BindingResource::Buffer(wgpu::BufferBinding { buffer, offset: 0, size })
            };
            let entries: Vec<_> = (source.bindings.iter())
                .filter_map(|b| Some((b.slot, buffer(b.slot)?)))
                .map(|(slot, b)| wgpu::BindGroupEntry { binding: slot as u32, resource: resource(slot, b) })
                .collect();
            let layout = &pipeline.layout;
            device.create_bind_group(&wgpu::BindGroupDescriptor { label: Some(source.stem), layout, entries: &entries })
        })
    }

    /// Drops the bindings that name the old buffer of colliders.
    pub(super) fn forget_colliders(&mut self) {
        self.groups.retain(|bindings, _| bindings.iter().all(|b| b.slot != Slot::Solids));
    }
}

/// The buffer of all colliders; one unused row where there is none, as no buffer may be empty.
pub(super) fn solids_buffer(device: &wgpu::Device, rows: &[SolidRow]) -> Buffer {
    let none = [bytemuck::Zeroable::zeroed()];
    upload(device, "solids", if rows.is_empty() { &none } else { rows }, BufferUsages::empty())
}

fn upload<T: Pod>(device: &wgpu::Device, label: &str, data: &[T], more: BufferUsages) -> Buffer {
    let usage = BufferUsages::STORAGE | BufferUsages::COPY_DST | more;
    device.create_buffer_init(&BufferInitDescriptor { label: Some(label), contents: cast_slice(data), usage })
}
