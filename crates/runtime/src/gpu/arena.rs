//! Cloths that lie in the same buffers, and the dispatch that they share.

use std::collections::HashMap;

use bytemuck::{Pod, cast_slice};
use wgpu::{Buffer, BufferUsages, CommandEncoder};

use super::contents::{Contents, Grids};
use super::pipelines::Pipeline;
use super::recording::Recording;
use super::span::Span;
use super::store::Store;
use super::upload::{empty, filled, upload};
use crate::form::Fused;
use crate::layout::{FrameRow, JobRow, StepRow};
use crate::shaders::Slot;
use crate::world::{Batch, World};

/// Cloths that share a dispatch: their state, the lists that are only read, and scratch.
pub(super) struct Arena {
    store: Store,
    /// [`Slot::Lists`], and where each of them begins \[bytes\].
    lists: Buffer,
    places: HashMap<Slot, u64>,
    /// [`Slot::Scratch`], with room for as many lists as any frame so far has there.
    scratch: Option<Buffer>,
    /// Where each cloth of the world's arena lies in the buffers, without numbers of a step. The room of a removed cloth stays
    /// unused.
    jobs: Vec<JobRow>,
    grids: Option<Grids>,
    /// The jobs that were written last.
    written: Vec<JobRow>,
    /// By shader and by the number of colliders.
    ready: HashMap<(Fused, usize), Ready>,
}

/// Bindings, and what they depend on.
struct Ready {
    first_job: u32,
    solids: Buffer,
    frames: Buffer,
    scratch: Option<Buffer>,
    group: wgpu::BindGroup,
}

impl Arena {
    /// Uploads what is only read of the cloths of a store.
    pub fn new(device: &wgpu::Device, world: &World, store: Store, cloths: &[usize]) -> Self {
        let contents = Contents::new(world, cloths);
        let (bytes, places) = contents.joined();
        let lists = upload(device, "lists", &bytes, BufferUsages::empty());
        let (jobs, written) = (contents.jobs, Vec::new());
        Arena { store, lists, places, scratch: None, jobs, grids: None, written, ready: HashMap::new() }
    }

    /// Lets one of its cloths go; whether it was the last.
    pub fn leave(&mut self, member: usize) -> bool {
        self.jobs.remove(member);
        self.jobs.is_empty()
    }

    /// Where a list that is only read, of vectors, one a particle, lies for one of its cloths.
    pub fn vectors(&self, member: usize, slot: Slot) -> Option<Span> {
        let job = self.jobs.get(member)?;
        let (offset, size) = (self.places.get(&slot)? + 16 * u64::from(job.first), 16 * u64::from(job.count));
        Some(Span { buffer: self.lists.clone(), offset, size })
    }

    /// Records what has changed of its grids and of the jobs of its batches, whose jobs lie in their order; in the order of the
    /// encoder, as frames that were recorded before may not have been submitted yet. To be called before any of the batches is
    /// dispatched.
    pub fn follow<'a>(
        &mut self,
        device: &wgpu::Device,
        world: &World,
        cloths: &[usize],
        batches: impl Iterator<Item = &'a Batch> + Clone,
        passes: &mut Recording,
    ) {
        let places = cloths.iter().zip(&self.jobs).map(|(cloth, job)| (*cloth, job.first, job.grid));
        if let Some(grids) = Grids::follow(&mut self.grids, world, places) {
            self.write(device, passes.between(), Slot::Grids, &grids);
        }
        let jobs = batches.flat_map(|batch| &batch.members).map(|m| self.job(world, cloths[*m], *m));
        if !jobs.clone().eq(self.written.iter().copied()) {
            let jobs: Vec<_> = jobs.collect();
            self.write(device, passes.between(), Slot::Jobs, &jobs);
            self.written = jobs;
        }
    }

    /// Records new rows of a list.
    fn write<T: Pod>(&self, device: &wgpu::Device, encoder: &mut CommandEncoder, slot: Slot, rows: &[T]) {
        let bytes: &[u8] = cast_slice(rows);
        if let (Some(at), false) = (self.places.get(&slot), bytes.is_empty()) {
            let from = filled(device, slot.name(), bytes, BufferUsages::COPY_SRC);
            encoder.copy_buffer_to_buffer(&from, 0, &self.lists, *at, bytes.len() as u64);
        }
    }

    /// The bindings of a batch whose jobs begin at `first_job`, made again only where that or a buffer is another.
    pub fn group(
        &mut self,
        device: &wgpu::Device,
        (batch, first_job): (&Batch, u32),
        pipeline: &Pipeline,
        (solids, frames): (&Buffer, &Buffer),
    ) -> &wgpu::BindGroup {
        let need = (16 * self.store.room() * pipeline.source.scratch) as u64;
        if self.scratch.as_ref().map_or(0, Buffer::size) < need {
            self.scratch = Some(empty(device, "scratch", need, BufferUsages::STORAGE));
        }
        let scratch = self.scratch.as_ref().filter(|_| need > 0);
        let same =
            |r: &Ready| (&r.solids, &r.frames, r.scratch.as_ref(), r.first_job) == (solids, frames, scratch, first_job);
        let key = (batch.fused.clone(), batch.solids);
        if !self.ready.get(&key).is_some_and(same) {
            let first = filled(device, "batch", cast_slice(&[first_job, 0, 0, 0]), BufferUsages::UNIFORM);
            let whole = |buffer| wgpu::BufferBinding { buffer, offset: 0, size: None };
            let row = std::num::NonZeroU64::new(size_of::<FrameRow>() as u64);
            let group = pipeline.bind(device, |slot| match slot {
                Slot::Batch => Some(whole(&first)),
                Slot::Lists => Some(whole(&self.lists)),
                Slot::Scratch => scratch.map(whole),
                Slot::Solids => Some(whole(solids)),
                Slot::Frame => Some(wgpu::BufferBinding { size: row, ..whole(frames) }),
                other => self.store.get(other).map(whole),
            });
            let (solids, frames, scratch) = (solids.clone(), frames.clone(), scratch.cloned());
            self.ready.insert(key.clone(), Ready { first_job, solids, frames, scratch, group });
        }
        &self.ready[&key].group
    }

    /// What a workgroup does for a cloth, with the numbers that are the cloth's own.
    fn job(&self, world: &World, index: usize, member: usize) -> JobRow {
        let (cloth, solid) = (&world.scene.cloths[index], world.first_solid(index) as u32);
        let steps = world.numbers(cloth).map(|step| StepRow::from(&step));
        let (keep, longest) = (steps.map(|s| s.keep), steps.map(|s| s.longest));
        JobRow { solid, keep, longest, hold: world.hold(index), ..self.jobs[member] }
    }
}
