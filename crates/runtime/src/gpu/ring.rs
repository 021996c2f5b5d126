//! Rows of numbers that change from step to step, or from frame to frame.

use wgpu::{Buffer, BufferUsages};

use super::upload::empty;

/// A buffer of rows that are written in turn: what was recorded with the last ones may not have been submitted yet.
pub(crate) struct Ring {
    pub buffer: Buffer,
    stride: u32,
    rows: u32,
    cursor: u32,
    last: Vec<u8>,
}

impl Ring {
    /// Room for `rows` rows of up to `bytes` bytes.
    pub fn new(device: &wgpu::Device, label: &str, bytes: usize, rows: u32) -> Self {
        // The largest alignment that a device may ask for.
        let stride = (bytes as u32).next_multiple_of(256);
        let usage = BufferUsages::UNIFORM | BufferUsages::COPY_DST;
        let buffer = empty(device, label, u64::from(stride * rows), usage);
        Ring { buffer, stride, rows, cursor: 0, last: Vec::new() }
    }

    /// Rows that there is room for.
    pub fn rows(&self) -> u32 {
        self.rows
    }

    /// Where a row lies; it is written only if it differs from the last one.
    pub fn offset(&mut self, queue: &wgpu::Queue, row: &[u8]) -> u32 {
        if self.last != row {
            self.cursor = (self.cursor + 1) % self.rows;
            queue.write_buffer(&self.buffer, u64::from(self.cursor * self.stride), row);
            self.last.clear();
            self.last.extend_from_slice(row);
        }
        self.cursor * self.stride
    }
}
