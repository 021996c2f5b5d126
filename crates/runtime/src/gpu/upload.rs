//! Buffers with something in them, and without.

use bytemuck::{Pod, cast_slice};
use wgpu::util::{BufferInitDescriptor, DeviceExt};
use wgpu::{Buffer, BufferUsages};

/// How buffers are used that a vertex shader reads.
pub(super) const DRAWN: BufferUsages = BufferUsages::VERTEX.union(BufferUsages::COPY_SRC);

/// A buffer to be written on the device, or to be mapped.
pub(super) fn empty(device: &wgpu::Device, label: &str, size: u64, usage: BufferUsages) -> Buffer {
    device.create_buffer(&wgpu::BufferDescriptor { label: Some(label), size, usage, mapped_at_creation: false })
}

/// A buffer for shaders.
pub(super) fn upload<T: Pod>(device: &wgpu::Device, label: &str, data: &[T], more: BufferUsages) -> Buffer {
    let usage = BufferUsages::STORAGE | BufferUsages::COPY_DST | more;
    device.create_buffer_init(&BufferInitDescriptor { label: Some(label), contents: cast_slice(data), usage })
}
