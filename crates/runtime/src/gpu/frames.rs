//! The numbers of whole frames.

use std::mem::offset_of;

use bytemuck::{bytes_of, cast_slice};
use wgpu::{Buffer, BufferUsages};

use super::ring::room_of;
use super::upload::filled;
use super::uploads::Uploads;
use crate::frame::Frame;
use crate::layout::{FrameRow, POSES, StepRow};

/// Distance of two rows of [`Frames::parts`] \[bytes\].
const PART: u32 = room_of(16);

/// The numbers of whole frames on the device.
pub(super) struct Frames {
    /// Those of the frames of batches, and all else that a frame uploads.
    pub ring: Uploads,
    /// Row n has the number n: which of its dispatches in a frame a batch is at.
    pub parts: Buffer,
}

impl Frames {
    pub fn new(device: &wgpu::Device) -> Self {
        Frames { ring: Uploads::new(device), parts: parts(device, 16) }
    }

    /// Makes room for a frame of batches that have `most` dispatches at most.
    pub fn make_room(&mut self, device: &wgpu::Device, most: u32) {
        if u64::from(most) * u64::from(PART) > self.parts.size() {
            self.parts = parts(device, most.next_power_of_two());
        }
    }

    /// Where the number of a dispatch lies.
    pub fn part(&self, n: u32) -> u32 {
        n * PART
    }
}

fn parts(device: &wgpu::Device, count: u32) -> Buffer {
    let row = |n: u32| std::iter::once(n).chain(std::iter::repeat_n(0, PART as usize / 4 - 1));
    let rows: Vec<u32> = (0..count).flat_map(row).collect();
    filled(device, "parts", cast_slice(&rows), BufferUsages::UNIFORM)
}

/// Bytes of the numbers of a frame.
pub(super) fn bytes(frame: &Frame) -> usize {
    offset_of!(FrameRow, rows) + (1 + groups(frame) as usize) * size_of::<StepRow>()
}

/// Steps for which colliders stay where they are.
fn together(frame: &Frame) -> u32 {
    if frame.swept > 0.0 { frame.steps.div_ceil(POSES).max(1) } else { frame.steps.max(1) }
}

/// Groups of such steps.
fn groups(frame: &Frame) -> u32 {
    frame.steps.div_ceil(together(frame)).max(1)
}

/// Puts the numbers of a frame among a number of colliders, with `most` steps in a dispatch, in the place of others. Those of a single cloth
/// are not among them, so the frame of any cloth will do.
pub(super) fn numbers(frame: &Frame, most: u32, solids: usize, bytes: &mut Vec<u8>) {
    let together = together(frame);
    // Batches whose frames are one dispatch have the same numbers, which are written once.
    let most = most.min(frame.steps).max(1);
    let first = std::iter::once(StepRow::from(&frame.step(0, 0)));
    let rows = first.chain((0..groups(frame)).map(|g| StepRow::from(&frame.step(1, g * together))));
    bytes.clear();
    bytes.extend_from_slice(cast_slice(&[frame.steps, frame.rounds, together, solids as u32, most, 0, 0, 0]));
    rows.for_each(|row| bytes.extend_from_slice(bytes_of(&row)));
}
