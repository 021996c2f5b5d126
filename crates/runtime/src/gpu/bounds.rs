//! Boxes around cloths on the GPU, brought back without waiting.

use std::collections::VecDeque;

use super::span::Span;
use super::staging::{Parcel, Staging};
use super::upload::empty;
use super::{Gpu, begin};
use crate::bounds::Bounds;
use crate::cpu::bounds;
use crate::error::Result;
use crate::form::Form;
use crate::passes::Pass;
use crate::shaders::Slot;
use crate::world::World;

/// Bytes from the box of a cloth to the next, where a binding may begin.
const STRIDE: u64 = 256;
/// Bytes of a box: seven numbers, and one that is unused.
const BYTES: u64 = 32;

/// The boxes of all cloths.
#[derive(Default)]
pub(super) struct Boxes {
    /// Where shaders leave them.
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
    /// By cloth: whether it has stayed where it was since.
    holds: Vec<bool>,
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
    pub fn settle(&mut self) -> Result<()> {
        while let Some(measured) = self.under_way.front() {
            let words = |bytes: &[u8]| -> Vec<[u32; 7]> {
                let of = |one: &[u8]| bytemuck::pod_read_unaligned(&one[..28]);
                bytes.chunks_exact(STRIDE as usize).map(of).collect()
            };
            let Some(words) = measured.parcel.open(words)? else { break };
            let Some(measured) = self.under_way.pop_front() else { break };
            for (cloth, words) in words.into_iter().enumerate().filter(|(cloth, _)| measured.holds[*cloth]) {
                let box_of = |extent| (Bounds::new(&extent, measured.step), measured.time);
                self.known[cloth] = bounds::read(words).map(box_of);
            }
            self.staging.put_back(measured.parcel);
        }
        Ok(())
    }
}

impl Gpu {
    /// Records the measurement of all boxes.
    pub fn record_bounds(&mut self, world: &World, encoder: &mut wgpu::CommandEncoder) {
        let count = self.cloths.len();
        let size = STRIDE * count as u64;
        if count == 0 {
            return;
        }
        let Some(parcel) = self.boxes.staging.take(&self.device, "boxes", size) else { return };
        let usage = wgpu::BufferUsages::STORAGE | wgpu::BufferUsages::COPY_DST | wgpu::BufferUsages::COPY_SRC;
        let new = || empty(&self.device, "bounds", size, usage);
        let buffer = self.boxes.buffer.get_or_insert_with(new).clone();
        self.boxes.known.resize(count, None);
        encoder.clear_buffer(&buffer, 0, None);
        let mut pass = begin(encoder, "bounds");
        let what = Form::Apart(Pass::Bounds);
        for cloth in 0..count {
            let place = || Span { buffer: buffer.clone(), offset: STRIDE * cloth as u64, size: BYTES };
            self.cloths[cloth].others.entry(Slot::Bounds).or_insert_with(place);
            self.run(&world.scene.cloths[cloth], &mut pass, cloth, (&what, 0));
        }
        drop(pass);
        encoder.copy_buffer_to_buffer(&buffer, 0, &parcel.staging, 0, size);
        let (time, step) = (world.control.clock.time, world.control.clock.dt_old);
        self.boxes.under_way.push_back(Measured { parcel, holds: vec![true; count], time, step });
    }

    /// The last box of a cloth that has arrived.
    pub fn bounds(&self, world: &World, cloth: usize) -> Option<Bounds> {
        let (bounds, time) = (*self.boxes.known.get(cloth)?)?;
        Some(Bounds { age: (world.control.clock.time - time).max(0.0), ..bounds })
    }

    /// Drops the boxes of a cloth, as it is somewhere else.
    pub fn forget_bounds(&mut self, cloth: usize) {
        self.boxes.known.get_mut(cloth).into_iter().for_each(|known| *known = None);
        let under_way = self.boxes.under_way.iter_mut();
        under_way.filter_map(|m| m.holds.get_mut(cloth)).for_each(|holds| *holds = false);
    }
}
