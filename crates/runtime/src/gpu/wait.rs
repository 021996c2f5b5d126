//! Reading buffers and pictures back and waiting for them, for tools and tests. No stepper calls it, and no page in a browser can.

use super::Span;
use super::lost::guard;
use super::mapped::block_on;
use super::read_back::{read_back_async, read_back_picture_async, read_back_u32_async};
use crate::error::Result;

/// The vectors in a part of a buffer such as those of [`crate::ClothBuffers`]. Submits a copy and waits for everything submitted
/// before it: a game should not call this, and a page in a browser cannot ([`crate::read_back_async`]). Errors on a device that is lost
/// ([`crate::Error::DeviceLost`]).
pub fn read_back(device: &wgpu::Device, queue: &wgpu::Queue, span: &Span) -> Result<Vec<[f32; 4]>> {
    guard(device, || block_on(device, read_back_async(device, queue, span)))
}

/// The same for whole numbers, such as [`crate::ClothBuffers::holes`].
pub fn read_back_u32(device: &wgpu::Device, queue: &wgpu::Queue, span: &Span) -> Result<Vec<u32>> {
    guard(device, || block_on(device, read_back_u32_async(device, queue, span)))
}

/// The pixels of a texture of four bytes per pixel, row by row from the top, as they lie in it. The texture needs `COPY_SRC`. Submits a
/// copy and waits for everything submitted before it. Errors on other formats and on a device that is lost.
pub fn read_back_picture(device: &wgpu::Device, queue: &wgpu::Queue, texture: &wgpu::Texture) -> Result<Vec<[u8; 4]>> {
    guard(device, || block_on(device, read_back_picture_async(device, queue, texture)))
}
