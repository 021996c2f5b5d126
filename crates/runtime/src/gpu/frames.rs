//! The numbers of whole frames.

use bytemuck::cast_slice;
use wgpu::{Buffer, BufferUsages};

use crate::cloth::Cloth;
use crate::layout::{FrameRow, POSES, StepRow};
use crate::step::Step;
use crate::world::World;

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

    /// Where the numbers of a frame of `steps` steps lie; they are written only if they differ from the last ones. Numbers of a single cloth
    /// are not among them, so any cloth will do.
    pub fn offset(&mut self, queue: &wgpu::Queue, world: &World, cloth: &Cloth, steps: u32) -> u32 {
        let together = steps.div_ceil(POSES).max(1);
        let row = |n: u32, first| {
            let left = world.left(n, steps.max(1));
            StepRow::from(&Step { left, ..world.step(cloth, first) })
        };
        let moves = world.left(0, 2) > 0.0;
        let groups = if moves { steps.div_ceil(together).max(1) } else { 1 };
        let mut rows = vec![row(0, true)];
        rows.extend((0..groups).map(|g| row(g * together, false)));
        let together = if moves { together } else { steps.max(1) };
        let solids = world.scene.colliders.len() as u32;
        let mut bytes: Vec<u8> = cast_slice(&[steps, world.options.iterations, together, solids]).to_vec();
        bytes.extend_from_slice(cast_slice(&rows));
        if bytes != self.last {
            self.cursor = (self.cursor + 1) % FRAMES;
            queue.write_buffer(&self.buffer, u64::from(self.cursor * STRIDE), &bytes);
            self.last = bytes;
        }
        self.cursor * STRIDE
    }
}
