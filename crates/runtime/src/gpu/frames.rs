//! The numbers of whole frames.

use std::mem::offset_of;
use std::ops::Range;

use bytemuck::{bytes_of, cast_slice};

use super::ring::{Ring, room_of};
use crate::frame::Frame;
use crate::layout::{FrameRow, POSES, StepRow};

/// Frames with new numbers that can be recorded before the first submission.
const FRAMES: u32 = 64;

/// Room for the numbers of frames.
pub(super) fn ring(device: &wgpu::Device) -> Ring {
    Ring::new(device, "frame", size_of::<FrameRow>(), FRAMES)
}

/// Frames of which there is room for the numbers.
const AHEAD: u64 = 8;

/// Makes room for the numbers of all dispatches of a frame, each as long as `one` at most \[bytes\].
pub(super) fn make_room(ring: &mut Ring, device: &wgpu::Device, dispatches: usize, one: usize) {
    let largest = size_of::<FrameRow>() as u64;
    let need = largest + AHEAD * dispatches as u64 * u64::from(room_of(one));
    if need > ring.size() {
        let rows = need.div_ceil(largest).next_power_of_two();
        *ring = Ring::new(device, "frame", size_of::<FrameRow>(), rows as u32);
    }
}

/// Bytes of the numbers of a frame of a number of steps.
pub(super) fn bytes(frame: &Frame) -> usize {
    offset_of!(FrameRow, rows) + (1 + groups(frame) as usize) * size_of::<StepRow>()
}

/// Groups of steps after which colliders are elsewhere.
fn groups(frame: &Frame) -> u32 {
    let together = frame.steps.div_ceil(POSES).max(1);
    if frame.swept > 0.0 { frame.steps.div_ceil(together).max(1) } else { 1 }
}

/// Puts the numbers of some steps of a frame among a number of colliders in the place of others. Those of a single cloth are not among them, so the frame of any cloth
/// will do.
pub(super) fn numbers(frame: &Frame, part: &Range<u32>, solids: usize, bytes: &mut Vec<u8>) {
    let together = frame.steps.div_ceil(POSES).max(1);
    let moves = frame.swept > 0.0;
    let first = std::iter::once(StepRow::from(&frame.step(0, 0)));
    let rows = first.chain((0..groups(frame)).map(|g| StepRow::from(&frame.step(1, g * together))));
    let together = if moves { together } else { frame.steps.max(1) };
    bytes.clear();
    bytes.extend_from_slice(cast_slice(&[frame.steps, frame.rounds, together, solids as u32]));
    bytes.extend_from_slice(cast_slice(&[part.start, part.end, 0, 0]));
    rows.for_each(|row| bytes.extend_from_slice(bytes_of(&row)));
}
