//! Cloths that lie in the same buffers, and the dispatch that they share.

use std::collections::HashMap;
use std::mem::offset_of;

use bytemuck::cast_slice;
use wgpu::{Buffer, BufferUsages};

use super::buffers::ClothBuffers;
use super::contents::{Contents, Grids};
use super::frames::Frames;
use super::pipelines::Pipeline;
use super::recording::Recording;
use super::ring;
use super::span::Span;
use super::store::{State, Store};
use super::turns::{TURNS, lies};
use super::upload::{empty, filled, upload};
use super::uploads::Uploads;
use crate::cloth::Cloth;
use crate::form::Fused;
use crate::fused::room_of;
use crate::layout::{FAULT_STRIDE, FaultRow, FrameRow, GridRow, JobRow, StepRow};
use crate::shaders::{Bound, LASTING, SCRATCH, Slot};
use crate::world::{Batch, World};

/// Cloths that share a dispatch: their state, the lists that are only read, and scratch.
pub(super) struct Arena {
    store: Store,
    /// [`Slot::Lists`], and where each of them begins \[bytes\].
    lists: Buffer,
    places: HashMap<Slot, u64>,
    /// [`Slot::Scratch`], with room for as many lists as any frame so far has there.
    scratch: Option<Buffer>,
    /// Where each cloth of the world's arena lies in the buffers, without numbers of a step; rows are slots.
    jobs: Vec<JobRow>,
    /// Places that no cloth has.
    spare: Vec<JobRow>,
    grids: Option<Grids>,
    grid_rows: Vec<GridRow>,
    /// The jobs of the last batches.
    batched: Vec<JobRow>,
    /// Both as they lie in the lists, to be copied there.
    table: Vec<u8>,
    /// Whether the lists have room for those that cuts change.
    opened: bool,
    /// Other buffers of steps: where tiles write, forces of air, multipliers, nodes of coarser grids.
    others: HashMap<Slot, Buffer>,
    /// By shader and by the number of colliders.
    ready: HashMap<(Fused, usize), Ready>,
    /// Of steps.
    groups: Vec<Group>,
}

/// Bindings, and what they depend on.
struct Ready {
    first_job: u32,
    solids: Buffer,
    frames: [Buffer; 2],
    scratch: Option<Buffer>,
    group: wgpu::BindGroup,
}

/// Bindings of steps: those that a place in the order of batches and a turn have, and what they depend on.
struct Group {
    place: usize,
    turned: [bool; 4],
    bindings: Vec<Bound>,
    jobs: [u32; 2],
    solids: Buffer,
    frames: [Buffer; 2],
    group: wgpu::BindGroup,
}

/// A batch in a frame that is being recorded.
#[derive(Clone, Copy, Default)]
pub(super) struct Underway {
    /// Its place among the batches of the frame.
    pub place: usize,
    /// Its first job, and the most grids of a cloth.
    pub jobs: [u32; 2],
    /// Where the numbers of its frame lie.
    pub offset: u32,
    /// As in [`super::ClothBuffers`].
    pub turned: [bool; 4],
}

impl Arena {
    /// Uploads what is only read of the cloths of a store.
    pub fn new(device: &wgpu::Device, world: &World, store: Store, cloths: &[usize]) -> Self {
        let contents = Contents::new(world, cloths);
        let (bytes, places) = contents.joined(store.room());
        let lists = upload(device, "lists", &bytes, BufferUsages::empty());
        let others = contents.nodes(device).map(|nodes| (Slot::Nodes, nodes)).into_iter().collect();
        Arena {
            store,
            lists,
            places,
            scratch: None,
            jobs: contents.jobs,
            spare: Vec::new(),
            grids: None,
            grid_rows: Vec::new(),
            batched: Vec::new(),
            table: Vec::new(),
            opened: false,
            others,
            ready: HashMap::new(),
            groups: Vec::new(),
        }
    }

    /// Bytes of the table that a frame uploads.
    pub fn need(&self) -> u64 {
        let grids = self.jobs.iter().map(|job| job.grid + job.grids).max().unwrap_or(0) as usize;
        let lists = self.places.get(&Slot::Jobs).zip(self.places.get(&Slot::Grids));
        u64::from(ring::room_of(
            lists.map_or(0, |(jobs, grids)| (grids - jobs) as usize) + grids * size_of::<GridRow>(),
        ))
    }

    /// Rebuilds the lists with room for those that cuts change: rest lengths and holes.
    pub fn open(&mut self, device: &wgpu::Device, world: &World, cloths: &[usize]) {
        if self.opened {
            return;
        }
        let places = cloths.iter().zip(&self.jobs).map(|(cloth, job)| (*cloth, job.row, job.first));
        let contents = Contents::placed(world, places);
        let (bytes, places) = contents.joined(self.store.room());
        self.lists = upload(device, "lists", &bytes, BufferUsages::empty());
        // Nodes lie where those lists say.
        self.others.extend(contents.nodes(device).map(|nodes| (Slot::Nodes, nodes)));
        (self.places, self.jobs, self.opened) = (places, contents.jobs, true);
        // All refer to the old lists.
        (self.grids, self.ready, self.groups) = (None, HashMap::new(), Vec::new());
    }

    /// Has the next frame upload the grids again: they hold constant rest lengths, which cut cloth does not have.
    pub fn renew(&mut self) {
        self.grids = None;
    }

    /// Records copies of the lists that cuts change, from the cloth's own buffers.
    pub fn mirror(
        &self,
        encoder: &mut wgpu::CommandEncoder,
        (cloth, slots): (&Cloth, usize),
        member: usize,
        own: &ClothBuffers,
    ) {
        let Some(job) = self.jobs.get(member).filter(|_| self.opened) else { return };
        for slot in [Slot::Rest, Slot::Tethers, Slot::Holes] {
            let from = if slot == Slot::Holes { own.holes.as_ref() } else { own.others.get(&slot) };
            if let (Some(from), Some(begin), Some(each)) = (from, self.places.get(&slot), slot.row(cloth, slots)) {
                let at = begin + each as u64 * u64::from(job.first);
                encoder.copy_buffer_to_buffer(&from.buffer, from.offset, &self.lists, at, from.size);
            }
        }
    }

    /// The buffer of what is only read.
    pub fn lists(&self) -> &Buffer {
        &self.lists
    }

    /// The buffer of the nodes of coarser grids; none without any.
    pub fn nodes(&self) -> Option<&Buffer> {
        self.others.get(&Slot::Nodes)
    }

    /// Lets one of its cloths go; whether it was the last.
    pub fn leave(&mut self, member: usize) -> bool {
        self.spare.push(self.jobs.remove(member));
        self.jobs.is_empty()
    }

    /// Leaves only the first of its places to cloths.
    pub fn keep_first(&mut self) {
        self.spare = self.jobs.split_off(1);
    }

    /// Lets a cloth have a place; where its state lies. None if another cloth has it.
    pub fn take(&mut self, slot: u32) -> Option<State<Span>> {
        let job = self.spare.swap_remove(self.spare.iter().position(|job| job.row == slot)?);
        self.jobs.insert(self.jobs.partition_point(|j| j.row < slot), job);
        // Its rows may not be there.
        self.grids = None;
        Some(self.store.span(job.row as usize, job.first as usize, job.count as usize))
    }

    /// Where a list that is only read, of vectors for each particle, lies for one of its cloths.
    pub fn vectors(&self, member: usize, slot: Slot) -> Option<Span> {
        let job = self.jobs.get(member)?;
        let each = 16 * slot.vectors();
        let (offset, size) = (self.places.get(&slot)? + each * u64::from(job.first), each * u64::from(job.count));
        Some(Span { buffer: self.lists.clone(), offset, size })
    }

    /// Records that its grids and the jobs of its batches, in the order of these, lie in its lists; to be called before any of the batches
    /// is dispatched. Recorded in every frame: one that was recorded before may not have been submitted yet, or never be.
    pub fn follow(
        &mut self,
        world: &World,
        cloths: &[usize],
        batches: &[Batch],
        (uploads, passes): (&mut Uploads, &mut Recording),
    ) {
        let (Some(begin), Some(grids)) = (self.places.get(&Slot::Jobs), self.places.get(&Slot::Grids)) else { return };
        let places = cloths.iter().zip(&self.jobs).map(|(cloth, job)| (*cloth, job.first, job.grid));
        let other = Grids::follow(&mut self.grids, world, places);
        let jobs = batches.iter().flat_map(|batch| &batch.members).map(|m| self.job(world, cloths[*m], *m));
        if other.is_some() || !jobs.clone().eq(self.batched.iter().copied()) {
            self.batched = jobs.collect();
            self.grid_rows = other.unwrap_or(std::mem::take(&mut self.grid_rows));
            self.table.clear();
            self.table.extend_from_slice(cast_slice(&self.batched));
            self.table.resize((grids - begin) as usize, 0);
            self.table.extend_from_slice(cast_slice(&self.grid_rows));
        }
        let (at, size) = (uploads.place(&self.table).into(), self.table.len() as u64);
        passes.between().copy_buffer_to_buffer(&uploads.buffer, at, &self.lists, *begin, size);
    }

    /// The bindings of a batch of whole frames that meets `met` colliders and whose jobs begin at `first_job`, made again only where the
    /// place or a buffer is another.
    pub fn group(
        &mut self,
        device: &wgpu::Device,
        (fused, met): (&Fused, usize),
        first_job: u32,
        pipeline: &Pipeline,
        (solids, frames): (&Buffer, &Frames),
    ) -> &wgpu::BindGroup {
        let need = (16 * self.store.room() * pipeline.source.scratch) as u64;
        if self.scratch.as_ref().map_or(0, Buffer::size) < need {
            self.scratch = Some(empty(device, "scratch", need, BufferUsages::STORAGE));
        }
        let scratch = self.scratch.as_ref().filter(|_| need > 0);
        let numbers = [&frames.ring.buffer, &frames.parts];
        let of = |r: &Ready| r.solids == *solids && r.frames.iter().eq(numbers);
        let same = |r: &Ready| of(r) && r.scratch.as_ref() == scratch && r.first_job == first_job;
        let key = (fused.clone(), met);
        if !self.ready.get(&key).is_some_and(same) {
            let first = filled(device, "batch", cast_slice(&[first_job, 0, 0, 0]), BufferUsages::UNIFORM);
            let whole = |buffer| wgpu::BufferBinding { buffer, offset: 0, size: None };
            let row = std::num::NonZeroU64::new(size_of::<FrameRow>() as u64);
            let part = std::num::NonZeroU64::new(16);
            let group = pipeline.bind(device, |slot| match slot {
                Slot::Batch => Some(whole(&first)),
                Slot::Lists => Some(whole(&self.lists)),
                Slot::Scratch => scratch.map(whole),
                Slot::Solids => Some(whole(solids)),
                Slot::Frame => Some(wgpu::BufferBinding { size: row, ..whole(numbers[0]) }),
                Slot::Part => Some(wgpu::BufferBinding { size: part, ..whole(numbers[1]) }),
                other => self
                    .others
                    .get(&other)
                    .filter(|_| other == Slot::Nodes)
                    .or_else(|| self.store.get(other))
                    .map(whole),
            });
            self.ready.retain(|_, r| of(r));
            let (solids, frames, scratch) = (solids.clone(), numbers.map(Buffer::clone), scratch.cloned());
            self.ready.insert(key.clone(), Ready { first_job, solids, frames, scratch, group });
        }
        &self.ready[&key].group
    }

    /// The bindings of a dispatch of a batch, made again only where a job or a buffer is another.
    pub fn step_group(
        &mut self,
        device: &wgpu::Device,
        of: &Underway,
        pipeline: &Pipeline,
        (solids, frames): (&Buffer, &Frames),
    ) -> &wgpu::BindGroup {
        let (bindings, numbers) = (&pipeline.source.bindings, [&frames.ring.buffer, &frames.parts]);
        let here = |g: &Group| g.place == of.place && g.turned == of.turned && g.bindings == *bindings;
        let fresh = |g: &Group| g.jobs == of.jobs && g.solids == *solids && g.frames.iter().eq(numbers);
        let at = self.groups.iter().position(here);
        let at = match at.filter(|at| fresh(&self.groups[*at])) {
            Some(at) => at,
            None => {
                let group = self.bind_step(device, of, pipeline, (solids, numbers));
                let (solids, frames) = (solids.clone(), numbers.map(Buffer::clone));
                let (place, turned, jobs, bindings) = (of.place, of.turned, of.jobs, bindings.clone());
                let group = Group { place, turned, bindings, jobs, solids, frames, group };
                match at {
                    Some(at) => self.groups[at] = group,
                    None => self.groups.push(group),
                }
                at.unwrap_or(self.groups.len() - 1)
            }
        };
        &self.groups[at].group
    }

    fn bind_step(
        &mut self,
        device: &wgpu::Device,
        of: &Underway,
        pipeline: &Pipeline,
        (solids, numbers): (&Buffer, [&Buffer; 2]),
    ) -> wgpu::BindGroup {
        let size = 16 * self.store.room() as u64;
        let own = |slot: &Slot| SCRATCH.contains(slot) || TURNS.iter().any(|(_, other)| other == slot);
        for slot in pipeline.source.bindings.iter().map(|b| b.slot).filter(own) {
            let usage = BufferUsages::STORAGE | BufferUsages::COPY_SRC;
            self.others.entry(slot).or_insert_with(|| empty(device, slot.name(), size, usage));
        }
        let [first_job, grids] = of.jobs;
        let first = filled(device, "batch", cast_slice(&[first_job, grids, 0, 0]), BufferUsages::UNIFORM);
        let whole = |buffer| wgpu::BufferBinding { buffer, offset: 0, size: None };
        let row = std::num::NonZeroU64::new(size_of::<FrameRow>() as u64);
        let part = std::num::NonZeroU64::new(16);
        pipeline.bind(device, |slot| match lies(of.turned, slot) {
            Slot::Batch => Some(whole(&first)),
            Slot::Lists => Some(whole(&self.lists)),
            Slot::Solids => Some(whole(solids)),
            Slot::Frame => Some(wgpu::BufferBinding { size: row, ..whole(numbers[0]) }),
            Slot::Part => Some(wgpu::BufferBinding { size: part, ..whole(numbers[1]) }),
            slot if LASTING.contains(&slot) => self.lasting(slot).map(|(buffer, offset, size)| {
                let size = std::num::NonZeroU64::new(size);
                wgpu::BufferBinding { buffer, offset, size }
            }),
            other => self.others.get(&other).or_else(|| self.store.get(other)).map(whole),
        })
    }

    /// Where a list lies that lasts from frame to frame: its buffer, where it begins there, and how long it is \[bytes\].
    fn lasting(&self, slot: Slot) -> Option<(&Buffer, u64, u64)> {
        let (buffer, room) = (self.store.get(Slot::Lasting)?, 16 * self.store.room() as u64);
        let begins = LASTING.iter().position(|s| *s == slot)? as u64 * room;
        Some((buffer, begins, room.min(buffer.size().checked_sub(begins)?)))
    }

    /// Brings what tiles have left in other buffers back to where hosts look for it, for the cloths of a batch.
    pub fn turn_back(&self, members: &[usize], turned: [bool; 4], encoder: &mut wgpu::CommandEncoder) {
        let lost = self.lasting(Slot::Lost).map(|(buffer, begins, _)| (buffer, begins));
        let own = |slot| self.store.get(slot).map(|buffer| (buffer, 0));
        let places = [own(Slot::Now), own(Slot::Before), lost];
        for ((to, (_, from)), _) in places.into_iter().zip(TURNS).zip(turned).filter(|(_, turned)| *turned) {
            let (Some((to, begins)), Some(from)) = (to, self.others.get(&from)) else { continue };
            // Cloths that lie one after the other are copied at once; nothing reads what is between them.
            let mut run: Option<(u32, u32)> = None;
            let mut copy = |(first, end): (u32, u32)| {
                let (at, size) = (16 * u64::from(first), 16 * u64::from(end - first));
                encoder.copy_buffer_to_buffer(from, at, to, begins + at, size);
            };
            for job in members.iter().map(|m| &self.jobs[*m]) {
                let end = job.first + job.count;
                match &mut run {
                    Some((_, last)) if room_of(*last as usize) as u32 == job.first => *last = end,
                    _ => run.replace((job.first, end)).into_iter().for_each(&mut copy),
                }
            }
            run.into_iter().for_each(copy);
        }
    }

    /// Clears the counters of the frame of some cloths, which no dispatch does.
    pub fn clear_faults(&self, members: &[usize], encoder: &mut wgpu::CommandEncoder) {
        let Some(faults) = self.store.get(Slot::Faults) else { return };
        for job in members.iter().map(|m| &self.jobs[*m]) {
            let row = 4 * u64::from(FAULT_STRIDE * job.row);
            encoder.clear_buffer(faults, row + offset_of!(FaultRow, particles) as u64, Some(4));
            encoder.clear_buffer(faults, row + offset_of!(FaultRow, speed) as u64, Some(8));
        }
    }

    /// The job of a workgroup for a cloth, with the numbers that are the cloth's own.
    fn job(&self, world: &World, index: usize, member: usize) -> JobRow {
        let solid = world.first_solid(index) as u32;
        let steps = world.numbers(index).map(|step| StepRow::from(&step));
        let (keep, longest) = (steps.map(|s| s.keep), steps.map(|s| s.longest));
        let (hold, solids) = (world.hold(index), world.solid_count(index) as u32);
        let [gravity, wind] = [steps[0].gravity, steps[0].wind].map(|[x, y, z]| [x, y, z, 0.0]);
        JobRow { solid, keep, longest, hold, solids, gravity, wind, ..self.jobs[member] }
    }
}
