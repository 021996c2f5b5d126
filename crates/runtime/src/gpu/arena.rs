//! Cloths that lie in the same buffers, and the dispatch that they share.

use std::collections::HashMap;

use wgpu::{Buffer, BufferUsages};

use super::contents::{Contents, Grids};
use super::pipelines::Pipeline;
use super::span::Span;
use super::store::Store;
use super::upload::upload;
use crate::form::Fused;
use crate::layout::{FrameRow, JobRow, StepRow};
use crate::shaders::Slot;
use crate::world::{Batch, World};

/// Cloths that share a dispatch: their state, the lists that are only read, and scratch.
pub(super) struct Arena {
    store: Store,
    buffers: HashMap<Slot, Buffer>,
    /// Where each cloth of the world's arena lies in the buffers, without numbers of a step. The room of a removed cloth stays
    /// unused.
    jobs: Vec<JobRow>,
    grids: Option<Grids>,
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
    /// Uploads what is only read of the cloths of a store.
    pub fn new(device: &wgpu::Device, world: &World, store: Store, cloths: &[usize]) -> Self {
        let contents = Contents::new(world, cloths);
        let buffers = contents.upload(device);
        Arena { store, buffers, jobs: contents.jobs, grids: None, ready: HashMap::new() }
    }

    /// Lets one of its cloths go; whether it was the last.
    pub fn leave(&mut self, member: usize) -> bool {
        self.jobs.remove(member);
        self.jobs.is_empty()
    }

    /// Where a list of vectors, one a particle, lies for one of its cloths.
    pub fn vectors(&self, member: usize, slot: Slot) -> Option<Span> {
        let job = self.jobs.get(member)?;
        let (offset, size) = (16 * u64::from(job.first), 16 * u64::from(job.count));
        Some(Span { buffer: self.buffers.get(&slot)?.clone(), offset, size })
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
        let cloths = &world.arenas[batch.arena];
        let places = cloths.iter().zip(&self.jobs).map(|(cloth, job)| (*cloth, job.first, job.grid));
        if let Some(grids) = Grids::follow(&mut self.grids, device, world, places) {
            self.buffers.insert(Slot::Grids, grids);
            self.ready.clear();
        }
        let rows: Vec<_> = batch.members.iter().map(|m| self.job(world, cloths[*m], *m)).collect();
        let same = |r: &Ready| r.rows == rows && r.solids == *solids && r.frames == *frames;
        if !self.ready.get(&batch.fused).is_some_and(same) {
            let scratch = |b: &&crate::shaders::Bound| matches!(b.slot, Slot::Sums | Slot::Moments | Slot::Field);
            for slot in pipeline.source.bindings.iter().filter(scratch).map(|b| b.slot) {
                let new = || upload(device, slot.name(), &vec![0f32; self.store.numbers()], BufferUsages::empty());
                self.buffers.entry(slot).or_insert_with(new);
            }
            let jobs = upload(device, "jobs", &rows, BufferUsages::empty());
            let whole = |buffer| wgpu::BufferBinding { buffer, offset: 0, size: None };
            let row = std::num::NonZeroU64::new(size_of::<FrameRow>() as u64);
            let group = pipeline.bind(device, |slot| match slot {
                Slot::Jobs => Some(whole(&jobs)),
                Slot::Solids => Some(whole(solids)),
                Slot::Frame => Some(wgpu::BufferBinding { size: row, ..whole(frames) }),
                other => self.store.get(other).or_else(|| self.buffers.get(&other)).map(whole),
            });
            let ready = Ready { rows, solids: solids.clone(), frames: frames.clone(), group };
            self.ready.insert(batch.fused.clone(), ready);
        }
        &self.ready[&batch.fused].group
    }

    /// What a workgroup does for a cloth, with the numbers that are the cloth's own.
    fn job(&self, world: &World, index: usize, member: usize) -> JobRow {
        let (cloth, solid) = (&world.scene.cloths[index], world.first_solid(index) as u32);
        let steps = world.numbers(cloth).map(|step| StepRow::from(&step));
        let (keep, longest) = (steps.map(|s| s.keep), steps.map(|s| s.longest));
        JobRow { solid, keep, longest, hold: world.hold(index), ..self.jobs[member] }
    }
}
