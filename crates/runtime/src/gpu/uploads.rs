//! The uploads of frames: rows of one buffer, written once per frame.

use std::ops::Range;

use wgpu::{Buffer, BufferUsages};

use super::Gpu;
use super::frames;
use super::joint;
use super::ring::room_of;
use super::skin;
use super::span::Span;
use super::upload::{empty, filled};
use crate::cloth::Cloth;
use crate::layout::{FrameRow, POSES, StepRow};
use crate::world::{Action, World};

/// Frames that a host can record before it submits the first, if all rows change in each of them.
const AHEAD: u64 = 8;
/// Bytes of the buffer at first.
const SMALLEST: u64 = 1 << 16;
/// Bytes of the buffer at most: dynamic offsets are 32 bits.
const LARGEST: u64 = 1 << 31;
/// Bytes that shaders bind from the start of any row on.
const BOUND: u64 = room_of(size_of::<FrameRow>()) as u64;
/// Longest list of an action that is a row \[bytes\]; a longer one has a buffer of its own.
pub(super) const LONGEST_ROW: usize = 1 << 16;

/// Writes of the queue that a stepper has made so far ([`crate::Stepper::uploads`]).
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub struct UploadCount {
    /// Calls of [`wgpu::Queue::write_buffer`].
    pub writes: u64,
    /// Bytes that they wrote.
    pub bytes: u64,
}

/// A queue that counts its writes.
pub(super) struct Writer {
    pub queue: wgpu::Queue,
    pub count: UploadCount,
}

impl Writer {
    /// Writes into a buffer. Everything that a stepper writes by the queue goes through here.
    pub fn write(&mut self, buffer: &Buffer, offset: u64, bytes: &[u8]) {
        self.queue.write_buffer(buffer, offset, bytes);
        self.count.writes += 1;
        self.count.bytes += bytes.len() as u64;
    }
}

/// A row: its place in an endless line, of which the buffer holds the end, and its length \[bytes\].
#[derive(Clone, Copy)]
struct Row {
    at: u64,
    size: usize,
}

/// A ring of rows of numbers: frames that were recorded with earlier rows may not have been submitted yet, so new rows go elsewhere. The
/// new rows of a frame are contiguous, so that one write has all of them. A row that is equal to that of the last frame stays where
/// it is.
pub(super) struct Uploads {
    pub buffer: Buffer,
    /// The contents of the buffer.
    copy: Vec<u8>,
    /// Where the next row lies, and the first that is not written yet.
    next: u64,
    unwritten: u64,
    /// Rows of the last frame and of this one, in order.
    last: Vec<Row>,
    rows: Vec<Row>,
    /// The number of the first row of this cloth, and of the cloth before.
    groups: [usize; 2],
}

impl Uploads {
    pub fn new(device: &wgpu::Device) -> Self {
        Uploads::of(device, SMALLEST)
    }

    fn of(device: &wgpu::Device, size: u64) -> Self {
        let usage = BufferUsages::UNIFORM | BufferUsages::STORAGE | BufferUsages::COPY_SRC | BufferUsages::COPY_DST;
        let (buffer, copy) = (empty(device, "frame", size, usage), vec![0; size as usize]);
        Uploads { buffer, copy, next: 0, unwritten: 0, last: Vec::new(), rows: Vec::new(), groups: [0; 2] }
    }

    fn size(&self) -> u64 {
        self.copy.len() as u64
    }

    /// Begins a frame with at most `need` bytes of rows, each rounded up by [`room_of`].
    pub fn begin(&mut self, device: &wgpu::Device, need: u64) {
        let need = need + BOUND;
        let most = device.limits().max_buffer_size.min(LARGEST);
        // Rows are used again from one half of the buffer while the other is written.
        let wish = (2 * AHEAD * need).next_power_of_two().min(most / 256 * 256);
        if wish > self.size() {
            *self = Uploads::of(device, wish);
        }
        std::mem::swap(&mut self.last, &mut self.rows);
        self.rows.clear();
        self.groups = [0; 2];
        let left = self.size() - self.next % self.size();
        if left < need {
            self.next += left;
        }
        self.unwritten = self.next;
    }

    /// Begins the rows of a cloth, which are often equal to those of the cloth before.
    pub fn group(&mut self) {
        self.groups = [self.rows.len(), self.groups[0]];
    }

    /// Where a row lies in the buffer \[bytes\], a multiple of 256.
    pub fn place(&mut self, row: &[u8]) -> u32 {
        let number = self.rows.len();
        let alike = self.rows.get(number - self.groups[0] + self.groups[1]);
        let known = [self.last.get(number), alike, self.rows.last()];
        let same = |r: &&Row| self.next - r.at <= self.size() / 2 && self.copy[self.range(r)] == *row;
        let found = known.into_iter().flatten().find(same).copied();
        let row = found.unwrap_or_else(|| self.append(row));
        self.rows.push(row);
        (row.at % self.size()) as u32
    }

    fn range(&self, row: &Row) -> Range<usize> {
        let at = (row.at % self.size()) as usize;
        at..at + row.size
    }

    fn append(&mut self, row: &[u8]) -> Row {
        // No table is as long as a buffer may be.
        let row = &row[..row.len().min(self.copy.len())];
        let (room, left) = (u64::from(room_of(row.len())), self.size() - self.next % self.size());
        if left < room.max(BOUND) {
            self.next += left;
        }
        let row_of = Row { at: self.next, size: row.len() };
        let here = self.range(&row_of);
        self.copy[here].copy_from_slice(row);
        self.next += room;
        row_of
    }

    /// Writes the new rows: by one write, if they take no more than [`Uploads::begin`] was told.
    pub fn flush(&mut self, writer: &mut Writer) {
        while self.unwritten < self.next {
            let first = self.unwritten % self.size();
            let end = self.size().min(first + self.next - self.unwritten);
            writer.write(&self.buffer, first, &self.copy[first as usize..end as usize]);
            self.unwritten += end - first;
        }
    }

    /// Drops all rows, as a call has failed before they were written.
    pub fn forget(&mut self) {
        self.last.clear();
        self.rows.clear();
        self.groups = [0; 2];
        self.unwritten = self.next;
    }
}

impl Gpu {
    /// Begins a frame of `steps` steps: finds the cloths that share dispatches, and makes room for what it uploads.
    pub fn begin(&mut self, world: &World, steps: u32) {
        world.batch(&mut self.batches);
        let one =
            |b: &crate::world::Batch| frames::bytes(&world.frame(world.arenas[b.arena].cloths[b.members[0]], steps));
        let batches: u64 = self.batches.iter().map(|b| u64::from(room_of(one(b)))).sum();
        let shared: u64 = self.arenas.iter().map(super::Arena::need).sum();
        let apart = separate_rows(world, steps) * u64::from(room_of(size_of::<StepRow>()));
        let meeting = joint::rows(world, steps) * u64::from(room_of(16));
        let need = batches + shared + apart + meeting + self.solids.need() + actions(&world.host.actions) + worn(world);
        self.frames.ring.begin(&self.device, need);
    }

    /// Writes the rows that recorded commands read.
    pub fn flush(&mut self) {
        self.frames.ring.flush(&mut self.writer);
    }

    /// Records the actions that wait for the next frame, outside of a frame.
    pub fn act_now(&mut self, world: &mut World, encoder: &mut wgpu::CommandEncoder) {
        self.frames.ring.begin(&self.device, actions(&world.host.actions));
        self.act(world, encoder);
        self.flush();
    }

    /// A list of an action, for shaders: with the frame's rows, unless it is long.
    pub(super) fn list(&mut self, label: &str, contents: &[u8]) -> Span {
        if contents.len() > LONGEST_ROW || contents.is_empty() {
            return filled(&self.device, label, contents, BufferUsages::STORAGE).into();
        }
        let offset = self.frames.ring.place(contents).into();
        Span { buffer: self.frames.ring.buffer.clone(), offset, size: contents.len() as u64 }
    }

    /// The writes of the queue so far.
    pub fn uploads(&self) -> UploadCount {
        self.writer.count
    }
}

/// Rows of the numbers of steps of all cloths that share no dispatch. A cloth shares those of the one before if they are alike.
fn separate_rows(world: &World, steps: u32) -> u64 {
    let (mut last, mut count) = (None, 0);
    for cloth in (0..world.runs.len()).filter(|c| world.is_apart(*c)) {
        let of = &world.scene.cloths[cloth];
        let local = world.local(cloth).map(|v| v.map(f64::to_bits));
        let own = Some((of.damping.to_bits(), of.speed_limit.to_bits(), local));
        count += u64::from(own != last);
        last = own;
    }
    // The first step, one for each pose of the colliders, and one for each of these that begins another.
    count * u64::from(steps.min(2 * POSES + 2))
}

/// Bytes of the lists of actions.
fn actions(list: &[Action]) -> u64 {
    let room = |bytes: usize| if bytes > LONGEST_ROW { 0 } else { u64::from(room_of(bytes)) };
    let one = |action: &Action| match action {
        Action::Cut { .. } => room(48),
        Action::Transform { chosen, .. } => room(64) + room(4 * chosen.len()),
        Action::Place { rows, .. } => room(16 * rows.len()) + room(8 * rows.len()),
        Action::Skin { to, .. } => room(skin::bytes(to.len())),
        Action::Inertia { .. } => room(112),
        Action::Aim { .. } | Action::Load { .. } => 0,
    };
    list.iter().map(one).sum()
}

/// Bytes of the numbers by which cloths on surfaces of bodies follow these.
fn worn(world: &World) -> u64 {
    let worn = world.scene.cloths.iter().filter(|cloth| cloth.body().is_some());
    let joints = |cloth: &Cloth| cloth.skin().map_or(0, |skin| skin.joints().len());
    worn.map(|cloth| u64::from(room_of(skin::bytes(joints(cloth)))) + u64::from(room_of(32))).sum()
}
