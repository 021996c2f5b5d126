//! The numbers of whole frames.

use std::ops::Range;

use bytemuck::{bytes_of, cast_slice};

use super::ring::Ring;
use crate::frame::Frame;
use crate::layout::{FrameRow, POSES, StepRow};

/// Frames with new numbers that can be recorded before the first submission.
const FRAMES: u32 = 64;

/// Room for the numbers of frames.
pub(super) fn ring(device: &wgpu::Device) -> Ring {
    Ring::new(device, "frame", size_of::<FrameRow>(), FRAMES)
}

/// Rows of numbers per frame, of which there is room for eight frames.
const AHEAD: u32 = 8;

/// Makes room for the numbers of as many dispatches as a frame has; whether they lie elsewhere now.
pub(super) fn make_room(ring: &mut Ring, device: &wgpu::Device, dispatches: u32) {
    let need = dispatches.saturating_mul(AHEAD);
    if need > ring.rows() {
        *ring = Ring::new(device, "frame", size_of::<FrameRow>(), need.next_power_of_two());
    }
}

/// Puts the numbers of some steps of a frame among a number of colliders in the place of others. Those of a single cloth are not among them, so the frame of any cloth
/// will do.
pub(super) fn numbers(frame: &Frame, part: &Range<u32>, solids: usize, bytes: &mut Vec<u8>) {
    let together = frame.steps.div_ceil(POSES).max(1);
    let moves = frame.swept > 0.0;
    let groups = if moves { frame.steps.div_ceil(together).max(1) } else { 1 };
    let first = std::iter::once(StepRow::from(&frame.step(0, 0)));
    let rows = first.chain((0..groups).map(|g| StepRow::from(&frame.step(1, g * together))));
    let together = if moves { together } else { frame.steps.max(1) };
    bytes.clear();
    bytes.extend_from_slice(cast_slice(&[frame.steps, frame.rounds, together, solids as u32]));
    bytes.extend_from_slice(cast_slice(&[part.start, part.end, 0, 0]));
    rows.for_each(|row| bytes.extend_from_slice(bytes_of(&row)));
}
