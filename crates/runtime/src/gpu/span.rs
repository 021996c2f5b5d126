//! A part of a buffer.

use wgpu::{Buffer, BufferBinding, BufferSlice};

/// A part of a buffer that cloths may share: `size` bytes from `offset`, a multiple of 256.
#[derive(Clone, Debug, PartialEq)]
pub struct Span {
    /// The buffer.
    pub buffer: Buffer,
    /// Where the part begins \[bytes\].
    pub offset: u64,
    /// How long it is \[bytes\].
    pub size: u64,
}

impl Span {
    /// The part as a shader binds it: its first element is the cloth's first.
    pub fn binding(&self) -> BufferBinding<'_> {
        BufferBinding { buffer: &self.buffer, offset: self.offset, size: std::num::NonZeroU64::new(self.size) }
    }

    /// The part as a vertex buffer.
    pub fn slice(&self) -> BufferSlice<'_> {
        self.buffer.slice(self.offset..self.offset + self.size)
    }
}

impl From<Buffer> for Span {
    fn from(buffer: Buffer) -> Self {
        let size = buffer.size();
        Span { buffer, offset: 0, size }
    }
}
