//! The numbers of whole frames.

use bytemuck::cast_slice;
use wgpu::{Buffer, BufferUsages};

use crate::frame::Frame;
use crate::layout::{FrameRow, POSES, StepRow};

/// Distance of the numbers of two frames: a multiple of the largest alignment that a device may ask for.
const STRIDE: u32 = (size_of::<FrameRow>() as u32).next_multiple_of(256);
/// Frames with new numbers that can be recorded before the first submission.
const FRAMES: u32 = 64;

/// A ring of frames.
pub(super) struct Frames {
    pub buffer: Buffer,
    last: Vec<u8>,
    cursor: u32,
}

impl Frames {
    pub fn new(device: &wgpu::Device) -> Self {
        let buffer = device.create_buffer(&wgpu::BufferDescriptor {
            label: Some("frame"),
            size: u64::from(STRIDE * FRAMES),
            usage: BufferUsages::UNIFORM | BufferUsages::COPY_DST,
            mapped_at_creation: false,
        });
        Frames { buffer, last: Vec::new(), cursor: 0 }
    }

    /// Where the numbers of a frame lie; they are written only if they differ from the last ones. Numbers of a single cloth
    /// are not among them, so any cloth will do.
    pub fn offset(&mut self, queue: &wgpu::Queue, frame: &Frame, solids: usize) -> u32 {
        let together = frame.steps.div_ceil(POSES).max(1);
        let moves = frame.swept > 0.0;
        let groups = if moves { frame.steps.div_ceil(together).max(1) } else { 1 };
        let mut rows = vec![StepRow::from(&frame.step(0, 0))];
        rows.extend((0..groups).map(|g| StepRow::from(&frame.step(1, g * together))));
        let together = if moves { together } else { frame.steps.max(1) };
        let mut bytes: Vec<u8> = cast_slice(&[frame.steps, frame.rounds, together, solids as u32]).to_vec();
        bytes.extend_from_slice(cast_slice(&rows));
        if bytes != self.last {
            self.cursor = (self.cursor + 1) % FRAMES;
            queue.write_buffer(&self.buffer, u64::from(self.cursor * STRIDE), &bytes);
            self.last = bytes;
        }
        self.cursor * STRIDE
    }
}
