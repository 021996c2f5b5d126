//! Boxes around cloths on the GPU, brought back without waiting.

use std::collections::VecDeque;

use super::span::Span;
use super::staging::{Parcel, Staging};
use super::upload::empty;
use super::{Gpu, Offsets, begin};
use crate::bounds::Bounds;
use crate::cpu::bounds;
use crate::error::Result;
use crate::form::Form;
use crate::handle::follow;
use crate::passes::Pass;
use crate::shaders::Slot;
use crate::world::World;
use crate::world::sleep::{Sought, corners};

/// Bytes from the box of a cloth to the next, where a binding may begin.
const STRIDE: u64 = 256;
/// Bytes of a box: seven numbers, and one that is unused.
const BYTES: u64 = 32;

/// The boxes of all cloths.
#[derive(Default)]
pub(super) struct Boxes {
    /// Where shaders leave them, a row each.
    buffer: Option<wgpu::Buffer>,
    staging: Staging,
    /// In the order of recording.
    under_way: VecDeque<Measured>,
    /// The last that have arrived, by cloth, and when they were measured \[s\].
    known: Vec<Option<(Bounds, f64)>>,
}

/// Boxes on their way to the host.
struct Measured {
    parcel: Parcel,
    /// By row: the index of its cloth now. None if the cloth has left, or was moved to somewhere else.
    cloths: Vec<Option<usize>>,
    /// By row: the state of its cloth at the time of recording.
    sought: Vec<Sought>,
    /// Time of the scene \[s\].
    time: f64,
    /// Length of the last step \[s\].
    step: f64,
}

impl Boxes {
    /// Asks for what was recorded.
    pub fn ask(&mut self) {
        self.under_way.iter_mut().for_each(|m| m.parcel.ask());
    }

    /// Takes in what has arrived.
    pub fn settle(&mut self, world: &mut World) -> Result<()> {
        while let Some(measured) = self.under_way.front() {
            let words = |bytes: &[u8]| -> Vec<[u32; 7]> {
                let of = |one: &[u8]| bytemuck::pod_read_unaligned(&one[..28]);
                bytes.chunks_exact(STRIDE as usize).map(of).collect()
            };
            let Some(words) = measured.parcel.open(words)? else { break };
            let Some(measured) = self.under_way.pop_front() else { break };
            let box_of = |extent| (Bounds::new(&extent, measured.step), measured.time);
            for ((words, cloth), sought) in words.into_iter().zip(&measured.cloths).zip(&measured.sought) {
                if let Some(cloth) = *cloth {
                    let extent = bounds::read(words);
                    self.known[cloth] = extent.map(box_of);
                    world.found(cloth, sought, corners(extent));
                }
            }
            self.staging.put_back(measured.parcel);
        }
        Ok(())
    }

    /// Lets a cloth go. Its boxes arrive nowhere, and those of the cloths behind it follow their cloths.
    pub fn leave(&mut self, cloth: usize) {
        if cloth < self.known.len() {
            self.known.remove(cloth);
        }
        self.keep(|index| follow(index, cloth));
    }

    /// Drops the boxes of a cloth, as it is somewhere else.
    pub(super) fn forget(&mut self, cloth: usize) {
        self.known.get_mut(cloth).into_iter().for_each(|known| *known = None);
        self.keep(|index| *index != cloth);
    }

    /// Keeps those boxes under way whose cloth passes a test, which may change its index.
    fn keep(&mut self, mut test: impl FnMut(&mut usize) -> bool) {
        for row in self.under_way.iter_mut().flat_map(|m| &mut m.cloths) {
            if !row.as_mut().is_some_and(&mut test) {
                *row = None;
            }
        }
    }

    /// The buffer with at least this number of rows. There are more than are needed now, so that few cloths that come need another one.
    fn rows(&mut self, device: &wgpu::Device, count: usize) -> wgpu::Buffer {
        let size = STRIDE * count.next_power_of_two() as u64;
        let usage = wgpu::BufferUsages::STORAGE | wgpu::BufferUsages::COPY_DST | wgpu::BufferUsages::COPY_SRC;
        let last = self.buffer.take().filter(|buffer| buffer.size() >= size);
        self.buffer.insert(last.unwrap_or_else(|| empty(device, "bounds", size, usage))).clone()
    }
}

impl Gpu {
    /// Records the measurement of the boxes of some cloths.
    pub fn record_bounds(&mut self, world: &mut World, encoder: &mut wgpu::CommandEncoder, cloths: &[usize]) {
        let count = cloths.len();
        if count == 0 {
            return;
        }
        let (buffer, size) = (self.boxes.rows(&self.device, count), STRIDE * count as u64);
        let Some(parcel) = self.boxes.staging.take(&self.device, "boxes", buffer.size()) else { return };
        self.boxes.known.resize(self.cloths.len(), None);
        encoder.clear_buffer(&buffer, 0, Some(size));
        let mut pass = begin(encoder, "bounds");
        let what = Form::Apart(Pass::Bounds);
        for (n, &cloth) in cloths.iter().enumerate() {
            let row = Span { buffer: buffer.clone(), offset: STRIDE * n as u64, size: BYTES };
            self.cloths[cloth].replace(Slot::Bounds, row);
            self.run(&world.scene.cloths[cloth], &mut pass, cloth, (&what, Offsets::default()));
        }
        drop(pass);
        encoder.copy_buffer_to_buffer(&buffer, 0, &parcel.staging, 0, size);
        let (time, step) = (world.control.clock.time, world.control.clock.dt_old);
        let sought = cloths.iter().map(|cloth| world.seek(*cloth)).collect();
        let cloths = cloths.iter().copied().map(Some).collect();
        self.boxes.under_way.push_back(Measured { parcel, cloths, sought, time, step });
    }

    /// The last box of a cloth that has arrived; none on a device that is lost.
    pub fn bounds(&self, world: &World, cloth: usize) -> Option<Bounds> {
        let (bounds, time) = self.boxes.known.get(cloth).copied().flatten().filter(|_| self.failure.is_none())?;
        Some(Bounds { age: (world.control.clock.time - time).max(0.0), ..bounds })
    }

    /// Drops the boxes of a cloth, as it is somewhere else.
    pub fn forget_bounds(&mut self, cloth: usize) {
        self.boxes.forget(cloth);
    }
}
