//! The mesh of the source of a cloth, moved with it.

use super::Stepper;
use crate::cpu::wrap::Sheet;
use crate::error::{Error, Result};
#[cfg(feature = "gpu")]
use crate::gpu::Span;
use crate::handle::ClothRef;
use crate::render_mesh::{RenderMesh, RenderVertex};

impl Stepper {
    /// The vertices of a mesh that is bound to a cloth, between the positions one step before (`fraction` 0) and those now (1); normals and
    /// tangents are those now. CPU backend only: on the GPU backend [`Stepper::record_wrap`] has them on the device, and
    /// [`RenderMesh::deform`] makes them from positions that are read back. `out` gets one entry per vertex, and keeps its memory.
    ///
    /// Errors on the GPU backend, if the cloth does not exist, and if the mesh belongs to another bundle.
    pub fn wrap(
        &self,
        cloth: impl Into<ClothRef>,
        mesh: &RenderMesh,
        fraction: f32,
        out: &mut Vec<RenderVertex>,
    ) -> Result<()> {
        let cloth = self.world.find(cloth.into())?;
        let (bodies, threads) = self.cpu.as_ref().ok_or(Error::GpuOnly("Stepper::wrap"))?;
        let body = &bodies[cloth];
        let normals = body.normals(threads);
        let sheet = Sheet { now: body.now(), before: body.before(), normals, fraction };
        mesh.run(threads, self.world.scene.cloths[cloth].name(), &sheet, out)
    }

    /// Records that the vertices of a mesh that is bound to a cloth, as [`Stepper::wrap`], are made at that place of the encoder: after
    /// [`Stepper::record`], with [`crate::Options::normals`] on. Returns where they lie: a [`RenderVertex`] of 48 bytes each, in a
    /// buffer for storage and vertices that stays until the call has another mesh.
    ///
    /// One dispatch for all vertices of the cloth. The first call makes two buffers, 112 bytes per vertex. A frame without a call has no
    /// cost, and a cloth without a call has no buffers. On the CPU backend they are made at once and uploaded.
    ///
    /// Errors without a device, if the device is lost or out of memory, if the cloth does not exist, and if the mesh belongs to another bundle
    /// or exceeds the largest buffer of the device.
    #[cfg(feature = "gpu")]
    pub fn record_wrap(
        &mut self,
        encoder: &mut wgpu::CommandEncoder,
        cloth: impl Into<ClothRef>,
        mesh: &RenderMesh,
        fraction: f32,
    ) -> Result<Span> {
        let cloth = self.world.find(cloth.into())?;
        let of = &self.world.scene.cloths[cloth];
        mesh.fits(of.name(), of.len())?;
        self.guarded(|stepper| {
            let mut made = Vec::new();
            if stepper.cpu.is_some() {
                stepper.wrap(cloth, mesh, fraction, &mut made)?;
            }
            let gpu = stepper.gpu.as_mut().ok_or(Error::NoGpu("Stepper::record_wrap"))?;
            let span = gpu.vertices(&stepper.world, cloth, mesh)?;
            match stepper.cpu {
                Some(_) => gpu.upload_wrap(&span, &made),
                None => gpu.record_wrap(&stepper.world, encoder, cloth, fraction),
            }
            Ok(span)
        })
    }
}
