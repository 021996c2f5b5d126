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
    /// Which dispatch of its frame a batch is at: [`Frames::whole`], [`Frames::begins`], [`Frames::within`], [`Frames::IDLE`].
    pub parts: Buffer,
}

impl Frames {
    pub fn new(device: &wgpu::Device) -> Self {
        Frames { ring: Uploads::new(device), parts: parts(device, 16) }
    }

    /// Makes room for a frame of batches that have `most` dispatches of whole frames, or steps, at most.
    pub fn make_room(&mut self, device: &wgpu::Device, most: u32) {
        if (1 + 2 * u64::from(most)) * u64::from(PART) > self.parts.size() {
            self.parts = parts(device, most.next_power_of_two());
        }
    }

    /// Where the numbers of a frame without steps lie.
    pub const IDLE: u32 = 0;

    /// Where those of the n-th dispatch of whole frames lie.
    pub fn whole(n: u32) -> u32 {
        Frames::begins(n)
    }

    /// Where those of the dispatch that begins step n lie: the last passes of the step before may still be due.
    pub fn begins(n: u32) -> u32 {
        (1 + 2 * n) * PART
    }

    /// Where those of another dispatch of step n lie, or of one that follows the last step.
    pub fn within(n: u32) -> u32 {
        (2 + 2 * n) * PART
    }
}

/// The rows of `count` steps, as shaders/part/jobs.wgsl reads them.
fn parts(device: &wgpu::Device, count: u32) -> Buffer {
    let steps = (0..count).flat_map(|n| [[n, n, u32::from(n == 0)], [n, n + 1, 0]]);
    let row = |row: [u32; 3]| row.into_iter().chain(std::iter::repeat_n(0, PART as usize / 4 - 3));
    let rows: Vec<u32> = std::iter::once([0; 3]).chain(steps).flat_map(row).collect();
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
    bytes.extend_from_slice(cast_slice(&[
        frame.steps,
        frame.rounds,
        together,
        solids as u32,
        most,
        frame.pyramid,
        0,
        0,
    ]));
    rows.for_each(|row| bytes.extend_from_slice(bytes_of(&row)));
}
