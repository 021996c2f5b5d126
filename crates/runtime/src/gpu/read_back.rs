//! Reading a buffer back, for tools and tests. No stepper calls it.

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
