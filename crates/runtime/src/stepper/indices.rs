//! The triangles of cloths, as index buffers have them.

use super::Stepper;
use crate::cpu::indices;
#[cfg(feature = "gpu")]
use crate::error::{Error, Result};
#[cfg(feature = "gpu")]
use crate::gpu::Span;
use crate::handle::ClothRef;

impl Stepper {
    /// The triangles of a cloth that no cut has taken away, as [`crate::Cloth::indices`]: three particles each,
    /// counter-clockwise seen from the front. They change with cuts alone. One pass over the texels. `None` for a cloth that does not exist, and
    /// on the GPU backend from the first cut on, when [`Stepper::index_buffer`] has them.
    pub fn indices(&self, cloth: impl Into<ClothRef>) -> Option<Vec<u32>> {
        let cloth = self.world.find(cloth.into()).ok()?;
        let of = &self.world.scene.cloths[cloth];
        let holes = match &self.cpu {
            Some((bodies, _)) => &bodies[cloth].holes[..],
            None if of.is_cut() => return None,
            None => &[],
        };
        Some(indices::triangles(&of.all_indices(holes)))
    }

    /// The triangles of a cloth in an index buffer on the device (`Uint32`), for `draw_indexed` with `0..size / 4`: six
    /// indices per texel, of which those of a triangle that is not there, or that a cut has taken away, are a single point. The
    /// number never changes. Made by the first call, also the first after [`Stepper::recover`], 24 bytes per texel, and kept in
    /// [`crate::ClothBuffers::indices`]; one dispatch follows each cut and each state that is loaded, and no other frame has any cost. A
    /// cloth that is cut already has its holes from the next frame on. Errors without a device, if it is lost or has no memory left, and if
    /// there is no such cloth.
    #[cfg(feature = "gpu")]
    pub fn index_buffer(&mut self, cloth: impl Into<ClothRef>) -> Result<Span> {
        let cloth = self.world.find(cloth.into())?;
        self.guarded(|stepper| {
            let gpu = stepper.gpu.as_mut().ok_or(Error::NoGpu("Stepper::index_buffer"))?;
            let (span, new) = gpu.index_buffer(&stepper.world, cloth);
            stepper.world.host.touched |= new;
            Ok(span)
        })
    }
}
