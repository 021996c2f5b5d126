//! Checks of buffers that the host passes in.

use wgpu::BufferUsages;

use super::Stepper;
use crate::error::{Error, Result};
use crate::gpu::Span;

impl Stepper {
    /// Refuses the CPU backend, which has another call for the same.
    pub(super) fn refuse_cpu(&self, call: &'static str, other: &'static str) -> Result<()> {
        if self.cpu.is_some() { Err(Error::CpuBackend(call, other)) } else { Ok(()) }
    }

    /// Refuses a part of a buffer that copies or shaders could not use.
    pub(super) fn fits(
        &self,
        cloth: usize,
        place: &Span,
        (usage, name): (BufferUsages, &'static str),
        what: &'static str,
    ) -> Result<()> {
        let found = place.buffer.size().saturating_sub(place.offset);
        let hint = if !place.buffer.usage().contains(usage) {
            "make it with the usage"
        } else if !place.offset.is_multiple_of(4) {
            "begin at a multiple of 4 bytes"
        } else if found < place.size {
            "make it larger"
        } else {
            return Ok(());
        };
        Err(self.wrong_buffer(cloth, what, place.size, found, name, hint))
    }

    /// The error of a buffer that does not do.
    pub(super) fn wrong_buffer(
        &self,
        cloth: usize,
        what: &'static str,
        need: u64,
        found: u64,
        usage: &'static str,
        hint: &'static str,
    ) -> Error {
        let cloth = self.world.scene.cloths.get(cloth).map_or_else(String::new, |c| c.name().into());
        Error::Buffer { cloth, what, need, found, usage, hint }
    }
}
