//! Reading buffers and pictures back without waiting.

use bytemuck::Pod;
use wgpu::BufferUsages;

use super::Span;
use super::lost::{guard_async, is_lost};
use super::mapped::bytes;
use super::upload::empty;
use crate::error::{Error, Result};

/// How buffers are used that the host maps.
pub(super) const MAPPED: BufferUsages = BufferUsages::MAP_READ.union(BufferUsages::COPY_DST);

/// [`crate::read_back`] without waiting: submits a copy when it is first polled, and is ready when the copy has arrived. In a browser the page
/// completes it. Elsewhere the host's calls of [`wgpu::Device::poll`] do, which [`crate::Stepper::settle`] makes too.
pub async fn read_back_async(device: &wgpu::Device, queue: &wgpu::Queue, span: &Span) -> Result<Vec<[f32; 4]>> {
    copied(device, queue, span).await
}

/// [`crate::read_back_u32`] without waiting, as [`read_back_async`].
pub async fn read_back_u32_async(device: &wgpu::Device, queue: &wgpu::Queue, span: &Span) -> Result<Vec<u32>> {
    copied(device, queue, span).await
}

/// [`crate::read_back_picture`] without waiting, as [`read_back_async`].
pub async fn read_back_picture_async(
    device: &wgpu::Device,
    queue: &wgpu::Queue,
    texture: &wgpu::Texture,
) -> Result<Vec<[u8; 4]>> {
    let format = texture.format();
    if format.block_copy_size(None) != Some(4) {
        return Err(Error::ReadBack(format!("a pixel of {format:?} does not have four bytes")));
    }
    if is_lost(device) {
        return Err(Error::DeviceLost);
    }
    let row = 4 * texture.width();
    let stride = row.next_multiple_of(wgpu::COPY_BYTES_PER_ROW_ALIGNMENT);
    let copy = || {
        let staging = empty(device, "picture", u64::from(stride) * u64::from(texture.height()), MAPPED);
        let layout = wgpu::TexelCopyBufferLayout { offset: 0, bytes_per_row: Some(stride), rows_per_image: None };
        let to = wgpu::TexelCopyBufferInfo { buffer: &staging, layout };
        let size = wgpu::Extent3d { depth_or_array_layers: 1, ..texture.size() };
        let mut encoder = device.create_command_encoder(&Default::default());
        encoder.copy_texture_to_buffer(texture.as_image_copy(), to, size);
        queue.submit([encoder.finish()]);
        Ok(staging)
    };
    let staging = guard_async(device, copy).await?;
    let pixels = |row: &[u8]| row.as_chunks::<4>().0.to_vec();
    let lines = |all: &[u8]| all.chunks_exact(stride as usize).flat_map(|l| pixels(&l[..row as usize])).collect();
    bytes(device, &staging, lines).await
}

async fn copied<A: Pod>(device: &wgpu::Device, queue: &wgpu::Queue, span: &Span) -> Result<Vec<A>> {
    if is_lost(device) {
        return Err(Error::DeviceLost);
    }
    let copy = || {
        let staging = empty(device, "read back", span.size, MAPPED);
        let mut encoder = device.create_command_encoder(&Default::default());
        encoder.copy_buffer_to_buffer(&span.buffer, span.offset, &staging, 0, span.size);
        queue.submit([encoder.finish()]);
        Ok(staging)
    };
    let staging = guard_async(device, copy).await?;
    bytes(device, &staging, bytemuck::pod_collect_to_vec).await
}
