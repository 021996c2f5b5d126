//! Buffers with something in them, and without.

use bytemuck::{Pod, cast_slice};
use wgpu::{Buffer, BufferUsages};

/// How buffers are used that a vertex shader reads.
pub(super) const DRAWN: BufferUsages = BufferUsages::VERTEX.union(BufferUsages::COPY_SRC);

/// A buffer to be written on the device, or to be mapped.
pub(super) fn empty(device: &wgpu::Device, label: &str, size: u64, usage: BufferUsages) -> Buffer {
    device.create_buffer(&wgpu::BufferDescriptor { label: Some(label), size, usage, mapped_at_creation: false })
}

/// A buffer with contents. On a device that is lost or has no memory left, which tells it, there is nothing to fill.
pub(crate) fn filled(device: &wgpu::Device, label: &str, contents: &[u8], usage: BufferUsages) -> Buffer {
    let size = (contents.len() as u64).next_multiple_of(wgpu::COPY_BUFFER_ALIGNMENT);
    let mapped_at_creation = size > 0;
    let descriptor = wgpu::BufferDescriptor { label: Some(label), size, usage, mapped_at_creation };
    let buffer = device.create_buffer(&descriptor);
    if mapped_at_creation && let Ok(mut view) = buffer.get_mapped_range_mut(..) {
        view.slice(..contents.len()).copy_from_slice(contents);
        drop(view);
        buffer.unmap();
    }
    buffer
}

/// A buffer for shaders.
pub(super) fn upload<T: Pod>(device: &wgpu::Device, label: &str, data: &[T], more: BufferUsages) -> Buffer {
    // States are copied out and in.
    let usage = BufferUsages::STORAGE | BufferUsages::COPY_DST | BufferUsages::COPY_SRC | more;
    filled(device, label, cast_slice(data), usage)
}
