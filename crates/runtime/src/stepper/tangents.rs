//! Tangents of cloths, for normal maps.

use super::Stepper;
use crate::cpu::body::view;
use crate::cpu::tangents;
#[cfg(feature = "gpu")]
use crate::error::{Error, Result};
#[cfg(feature = "gpu")]
use crate::gpu::Span;
use crate::handle::ClothRef;

impl Stepper {
    /// Unit tangents of a cloth, across its normals: the direction in which u of [`crate::Cloth::uv`] grows. The fourth component
    /// is 1 or -1, so that cross(normal, tangent) times it leads along v. 0 where there is no particle, or no normal that is
    /// not along u. Duplicates of a seam point may differ, as texture coordinates do. CPU backend only: `None` on the GPU backend
    /// and for a cloth that does not exist. Made by each call, in one pass over the particles; the first call
    /// looks at the texture coordinates too.
    pub fn tangents(&self, cloth: impl Into<ClothRef>) -> Option<Vec<[f32; 4]>> {
        let cloth = self.world.find(cloth.into()).ok()?;
        let (bodies, threads) = self.cpu.as_ref()?;
        let (body, of) = (&bodies[cloth], &self.world.scene.cloths[cloth]);
        let (normals, charts) = (body.normals(threads), self.world.runs[cloth].charts(of));
        let mut all = vec![[0.0; 4]; of.len()];
        for g in of.grids() {
            let range = g.range();
            let read = (&normals[range.clone()], &charts[range.clone()]);
            tangents::run(threads, view(body.now(), &body.holes, g), read, &mut all[range]);
        }
        Some(all)
    }

    /// Records that the tangents of a cloth, as [`Stepper::tangents`], are made of its positions and normals at that place of
    /// the encoder: after [`Stepper::record`], with [`crate::Options::normals`] on. Returns where they lie, also in
    /// [`crate::ClothBuffers::tangents`]: a `vec4<f32>` per particle, in a buffer for storage and vertices.
    ///
    /// One dispatch, 48 bytes read and 16 written per particle. The first call makes two buffers of 16 bytes per particle.
    /// A frame without a call has no cost. On the CPU backend they are made at once and uploaded. Errors without a
    /// device, if it is lost or has no memory left, and if there is no such cloth.
    #[cfg(feature = "gpu")]
    pub fn record_tangents(&mut self, encoder: &mut wgpu::CommandEncoder, cloth: impl Into<ClothRef>) -> Result<Span> {
        let cloth = self.world.find(cloth.into())?;
        self.guarded(|stepper| {
            let made = stepper.tangents(cloth);
            let gpu = stepper.gpu.as_mut().ok_or(Error::NoGpu("Stepper::record_tangents"))?;
            Ok(match made {
                Some(made) => gpu.upload_tangents(cloth, &made),
                None => gpu.record_tangents(&stepper.world, encoder, cloth),
            })
        })
    }
}
