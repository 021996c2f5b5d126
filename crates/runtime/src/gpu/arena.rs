//! Cloths that lie in the same buffers, and the dispatch that they share.

use std::collections::HashMap;

use wgpu::{Buffer, BufferUsages};

use super::buffers::{DRAWN, Spans, grid_rows, soft_row, upload};
use super::contents::Contents;
use super::pipelines::Pipeline;
use super::span::Span;
use crate::cpu::start::Start;
use crate::form::Fused;
use crate::layout::{FAULT_BYTES, FAULT_STRIDE, FrameRow, JobRow, StepRow};
use crate::shaders::Slot;
use crate::world::{Batch, World};

/// Buffers of several cloths, one after the other.
pub(super) struct Arena {
    /// Index of every cloth.
    cloths: Vec<usize>,
    buffers: HashMap<Slot, Buffer>,
    /// What is where, without numbers of a step.
    jobs: Vec<JobRow>,
    /// [`soft_row`] of each, as its grids have it.
    softs: Vec<f32>,
    ready: HashMap<Fused, Ready>,
}

/// A batch as it was dispatched last.
struct Ready {
    rows: Vec<JobRow>,
    solids: Buffer,
    frames: Buffer,
    group: wgpu::BindGroup,
}

impl Arena {
    /// Uploads the cloths of an index list.
    pub fn new(device: &wgpu::Device, world: &World, starts: &[Start<f32>], cloths: &[usize]) -> Self {
        let contents = Contents::new(world, cloths);
        let mut lists: [Vec<[f32; 4]>; 3] = Default::default();
        for (index, job) in cloths.iter().zip(&contents.jobs) {
            let start = &starts[*index];
            for (list, data) in lists.iter_mut().zip([&start.now, &start.before, &start.normals]) {
                // Between cloths there are no particles.
                list.resize(job.first as usize, [0.0, 0.0, 0.0, -1.0]);
                list.extend(data);
            }
        }
        let none = BufferUsages::empty();
        let [now, before, normals] = lists;
        let mut buffers = contents.upload(device);
        let faults = vec![0u32; FAULT_STRIDE as usize * contents.jobs.len()];
        buffers.extend([
            (Slot::Good, upload(device, "good", &now, none)),
            (Slot::Now, upload(device, "now", &now, DRAWN)),
            (Slot::Before, upload(device, "before", &before, DRAWN)),
            (Slot::Normals, upload(device, "normals", &normals, DRAWN)),
            (Slot::Faults, upload(device, "faults", &faults, BufferUsages::COPY_SRC)),
        ]);
        if cloths.iter().any(|c| world.scene.cloths[*c].is_exact()) {
            buffers.insert(Slot::Lost, upload(device, "lost", &vec![[0f32; 4]; now.len()], none));
        }
        let softs = cloths.iter().map(|c| soft_row(&world.scene.cloths[*c], world.control.clock.dt)).collect();
        Arena { cloths: cloths.to_vec(), buffers, jobs: contents.jobs, softs, ready: HashMap::new() }
    }

    /// Where each of its cloths lies.
    pub fn spans(&self) -> impl Iterator<Item = (usize, Spans)> {
        self.cloths.iter().zip(&self.jobs).map(|(cloth, job)| {
            let part = |slot, offset: usize, size: usize| Span {
                buffer: self.buffers[&slot].clone(),
                offset: offset as u64,
                size: size as u64,
            };
            let list = |slot| part(slot, 16 * job.first as usize, 16 * job.count as usize);
            let spans = Spans {
                now: list(Slot::Now),
                before: list(Slot::Before),
                normals: list(Slot::Normals),
                good: Some(list(Slot::Good)),
                lost: self.buffers.contains_key(&Slot::Lost).then(|| list(Slot::Lost)),
                faults: Some(part(Slot::Faults, 4 * (FAULT_STRIDE * job.row) as usize, FAULT_BYTES)),
            };
            (*cloth, spans)
        })
    }

    /// Where a list of vectors, one a particle, lies for one of its cloths.
    pub fn vectors(&self, cloth: usize, slot: Slot) -> Option<Span> {
        let job = &self.jobs[self.cloths.iter().position(|c| *c == cloth)?];
        let (offset, size) = (16 * u64::from(job.first), 16 * u64::from(job.count));
        Some(Span { buffer: self.buffers.get(&slot)?.clone(), offset, size })
    }

    /// Grids with the bounds of diagonals that steps have now. Recorded frames that use the last ones may not have been submitted
    /// yet, so the last ones stay as they are.
    fn follow(&mut self, device: &wgpu::Device, world: &World) {
        let dt = world.control.clock.dt;
        let cloths = || self.cloths.iter().map(|c| &world.scene.cloths[*c]);
        if cloths().map(|c| soft_row(c, dt)).eq(self.softs.iter().copied()) {
            return;
        }
        let softs: Vec<_> = cloths().map(|c| soft_row(c, dt)).collect();
        let each = cloths().zip(&self.jobs).zip(&softs);
        let grids: Vec<_> = each.flat_map(|((cloth, job), soft)| grid_rows(cloth, job.first, *soft)).collect();
        self.buffers.insert(Slot::Grids, upload(device, "grids", &grids, BufferUsages::empty()));
        self.softs = softs;
        self.ready.clear();
    }

    /// The bindings of a batch, made again only where cloths fell asleep or woke, or numbers changed.
    pub fn group(
        &mut self,
        device: &wgpu::Device,
        world: &World,
        batch: &Batch,
        pipeline: &Pipeline,
        (solids, frames): (&Buffer, &Buffer),
    ) -> &wgpu::BindGroup {
        self.follow(device, world);
        let rows: Vec<_> = batch.members.iter().map(|m| self.job(world, *m)).collect();
        let same = |r: &Ready| r.rows == rows && r.solids == *solids && r.frames == *frames;
        if !self.ready.get(&batch.fused).is_some_and(same) {
            let scratch = |b: &&crate::shaders::Bound| matches!(b.slot, Slot::Sums | Slot::Moments | Slot::Field);
            for slot in pipeline.source.bindings.iter().filter(scratch).map(|b| b.slot) {
                let numbers = self.buffers[&Slot::Now].size() as usize / 4;
                let new = || upload(device, slot.name(), &vec![0f32; numbers], BufferUsages::empty());
                self.buffers.entry(slot).or_insert_with(new);
            }
            let jobs = upload(device, "jobs", &rows, BufferUsages::empty());
            let whole = |buffer| wgpu::BufferBinding { buffer, offset: 0, size: None };
            let row = std::num::NonZeroU64::new(size_of::<FrameRow>() as u64);
            let group = pipeline.bind(device, |slot| match slot {
                Slot::Jobs => Some(whole(&jobs)),
                Slot::Solids => Some(whole(solids)),
                Slot::Frame => Some(wgpu::BufferBinding { size: row, ..whole(frames) }),
                other => self.buffers.get(&other).map(whole),
            });
            let ready = Ready { rows, solids: solids.clone(), frames: frames.clone(), group };
            self.ready.insert(batch.fused.clone(), ready);
        }
        &self.ready[&batch.fused].group
    }

    /// What a workgroup does for a cloth, with the numbers that are the cloth's own.
    fn job(&self, world: &World, member: usize) -> JobRow {
        let index = self.cloths[member];
        let (cloth, solid) = (&world.scene.cloths[index], world.first_solid(index) as u32);
        let steps = world.numbers(cloth).map(|step| StepRow::from(&step));
        JobRow { solid, keep: steps.map(|s| s.keep), longest: steps.map(|s| s.longest), ..self.jobs[member] }
    }
}
