//! Rows of numbers that change from picture to picture.

use wgpu::{Buffer, BufferUsages};

use super::upload::empty;

/// A buffer of rows that are written in turn: what was recorded with the last ones may not have been submitted yet.
pub(crate) struct Ring {
    pub buffer: Buffer,
    /// Bytes of the largest row, of which as many are bound for every row.
    largest: u32,
    /// Where the last row lies, and where the next one will \[bytes\].
    at: u32,
    next: u32,
    last: Vec<u8>,
}

impl Ring {
    /// Room for `rows` rows of up to `bytes` bytes, or more that are smaller.
    pub fn new(device: &wgpu::Device, label: &str, bytes: usize, rows: u32) -> Self {
        let largest = room_of(bytes);
        let usage = BufferUsages::UNIFORM | BufferUsages::COPY_DST;
        let buffer = empty(device, label, u64::from(largest) * u64::from(rows), usage);
        Ring { buffer, largest, at: 0, next: 0, last: Vec::new() }
    }

    /// Bytes of all rows.
    pub fn size(&self) -> u64 {
        self.buffer.size()
    }

    /// Where a row lies; it is written only if it differs from the last one.
    pub fn offset(&mut self, queue: &wgpu::Queue, row: &[u8]) -> u32 {
        if self.last != row {
            let fits = u64::from(self.next) + u64::from(self.largest) <= self.size();
            self.at = if fits { self.next } else { 0 };
            self.next = self.at + room_of(row.len());
            queue.write_buffer(&self.buffer, u64::from(self.at), row);
            self.last.clear();
            self.last.extend_from_slice(row);
        }
        self.at
    }
}

/// Bytes from the start of a row to that of the next one: a multiple of the alignment that every device accepts.
pub(super) const fn room_of(bytes: usize) -> u32 {
    (bytes as u32).next_multiple_of(256)
}
