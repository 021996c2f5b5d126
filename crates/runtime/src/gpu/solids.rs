//! The colliders on the device, a list for each coat that cloths have.

use bytemuck::{Zeroable, cast_slice};
use wgpu::{Buffer, BufferUsages};

use super::ring::room_of;
use super::span::Span;
use super::upload::upload;
use super::uploads::Uploads;
use crate::layout::SolidRow;
use crate::world::World;

/// All lists in one buffer.
pub(super) struct Solids {
    pub buffer: Buffer,
    rows: Vec<SolidRow>,
    /// Whether the rows are others than the buffer had at first: then every frame copies them, as one that was recorded before may
    /// not have been submitted yet, or never be.
    changed: bool,
    /// The list of each cloth: its first collider, and their number.
    met: Vec<(usize, usize)>,
}

impl Solids {
    /// Uploads the colliders of a scene.
    pub fn new(device: &wgpu::Device, world: &World) -> Self {
        let rows = rows(world);
        let buffer = upload(device, "solids", &rows, BufferUsages::empty());
        Solids { buffer, rows, changed: false, met: places(world).collect() }
    }

    /// Takes them in again, to another buffer only if their number has changed; whether any cloth has to look elsewhere for those that
    /// it meets. `alike`: none has.
    pub fn write(&mut self, device: &wgpu::Device, world: &World, alike: bool) -> bool {
        let rows = rows(world);
        if rows.len() != self.rows.len() {
            *self = Solids::new(device, world);
            return true;
        }
        (self.rows, self.changed) = (rows, true);
        if alike {
            return false;
        }
        let met = !places(world).eq(self.met.iter().copied());
        if met {
            self.met = places(world).collect();
        }
        met
    }

    /// Bytes that a frame uploads.
    pub fn need(&self) -> u64 {
        if self.changed { u64::from(room_of(size_of_val(&self.rows[..]))) } else { 0 }
    }

    /// Records that the rows of now are copied to where shaders read them.
    pub fn follow(&self, uploads: &mut Uploads, encoder: &mut wgpu::CommandEncoder) {
        if self.changed {
            let at = uploads.place(cast_slice(&self.rows));
            encoder.copy_buffer_to_buffer(&uploads.buffer, at.into(), &self.buffer, 0, self.buffer.size());
        }
    }

    /// Those that a cloth meets.
    pub fn of(&self, world: &World, cloth: usize) -> Span {
        let row = size_of::<SolidRow>();
        let (first, count) = (world.first_solid(cloth), world.solid_count(cloth).max(1));
        Span { buffer: self.buffer.clone(), offset: (first * row) as u64, size: (count * row) as u64 }
    }
}

/// The list of each cloth.
fn places(world: &World) -> impl Iterator<Item = (usize, usize)> {
    (0..world.runs.len()).map(|cloth| (world.first_solid(cloth), world.solid_count(cloth)))
}

/// The lists; an unused row where the last one is empty.
fn rows(world: &World) -> Vec<SolidRow> {
    let mut rows: Vec<SolidRow> = Vec::new();
    for (coat, list) in world.solids().into_iter().enumerate() {
        rows.resize(world.coats.first(coat), SolidRow::zeroed());
        rows.extend(list.into_iter().map(SolidRow::from));
    }
    // An empty list at the end is bound like any other.
    let last = world.coats.first(world.coats.len().saturating_sub(1));
    rows.resize(rows.len().max(last + 1), SolidRow::zeroed());
    rows
}
