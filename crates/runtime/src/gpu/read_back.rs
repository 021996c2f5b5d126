//! Reading buffers and pictures back, for tools and tests. No stepper calls it.

use std::sync::mpsc::channel;

use wgpu::BufferUsages;

use super::Span;
use super::lost::{guard, is_lost, poll};
use super::upload::empty;
use crate::error::{Error, Result};

/// How buffers are used that the host maps.
pub(super) const MAPPED: BufferUsages = BufferUsages::MAP_READ.union(BufferUsages::COPY_DST);

/// The vectors in a part of a buffer such as those of [`crate::ClothBuffers`]. Submits a copy and waits for everything submitted
/// before it: a game should not call this. Errors on a device that is lost ([`Error::DeviceLost`]).
pub fn read_back(device: &wgpu::Device, queue: &wgpu::Queue, span: &Span) -> Result<Vec<[f32; 4]>> {
    guard(device, || read_bytes(device, &copied(device, queue, span)?, bytemuck::pod_collect_to_vec))
}

/// The same for whole numbers, such as [`crate::ClothBuffers::holes`].
pub fn read_back_u32(device: &wgpu::Device, queue: &wgpu::Queue, span: &Span) -> Result<Vec<u32>> {
    guard(device, || read_bytes(device, &copied(device, queue, span)?, bytemuck::pod_collect_to_vec))
}

/// The pixels of a texture of four bytes per pixel, row by row from the top, as they lie in it. The texture needs `COPY_SRC`. Submits a
/// copy and waits for everything submitted before it. Errors on other formats and on a device that is lost.
pub fn read_back_picture(device: &wgpu::Device, queue: &wgpu::Queue, texture: &wgpu::Texture) -> Result<Vec<[u8; 4]>> {
    let format = texture.format();
    if format.block_copy_size(None) != Some(4) {
        return Err(Error::ReadBack(format!("a pixel of {format:?} does not have four bytes")));
    }
    guard(device, || {
        if is_lost(device) {
            return Err(Error::DeviceLost);
        }
        let row = 4 * texture.width();
        let stride = row.next_multiple_of(wgpu::COPY_BYTES_PER_ROW_ALIGNMENT);
        let staging = empty(device, "picture", u64::from(stride) * u64::from(texture.height()), MAPPED);
        let layout = wgpu::TexelCopyBufferLayout { offset: 0, bytes_per_row: Some(stride), rows_per_image: None };
        let to = wgpu::TexelCopyBufferInfo { buffer: &staging, layout };
        let size = wgpu::Extent3d { depth_or_array_layers: 1, ..texture.size() };
        let mut encoder = device.create_command_encoder(&Default::default());
        encoder.copy_texture_to_buffer(texture.as_image_copy(), to, size);
        queue.submit([encoder.finish()]);
        let pixels = |row: &[u8]| row.as_chunks::<4>().0.to_vec();
        read_bytes(device, &staging, |bytes| {
            bytes.chunks_exact(stride as usize).flat_map(|line| pixels(&line[..row as usize])).collect()
        })
    })
}

fn copied(device: &wgpu::Device, queue: &wgpu::Queue, span: &Span) -> Result<wgpu::Buffer> {
    if is_lost(device) {
        return Err(Error::DeviceLost);
    }
    let staging = empty(device, "read back", span.size, MAPPED);
    let mut encoder = device.create_command_encoder(&Default::default());
    encoder.copy_buffer_to_buffer(&span.buffer, span.offset, &staging, 0, span.size);
    queue.submit([encoder.finish()]);
    Ok(staging)
}

/// Maps a buffer that the host may read, waits for it, and hands its bytes over.
pub(crate) fn read_bytes<A>(device: &wgpu::Device, staging: &wgpu::Buffer, take: impl FnOnce(&[u8]) -> A) -> Result<A> {
    let (send, receive) = channel();
    let failed = |e: &dyn std::fmt::Display| Error::ReadBack(e.to_string());
    staging.slice(..).map_async(wgpu::MapMode::Read, move |result| {
        // The receiver waits below.
        let _ = send.send(result);
    });
    poll(device, wgpu::PollType::wait_indefinitely())?;
    receive.recv().map_err(|e| failed(&e))?.map_err(|e| failed(&e))?;
    let view = staging.slice(..).get_mapped_range().map_err(|e| failed(&e))?;
    let taken = take(&view);
    drop(view);
    staging.unmap();
    Ok(taken)
}
