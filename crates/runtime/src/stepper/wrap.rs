//! The mesh of the source of a cloth, moved with it.

use super::Stepper;
use crate::cloth::Rows;
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
        mesh.run(threads, self.world.scene.cloths[cloth].name(), &sheet, out)?;
        match self.skin_of(cloth, mesh, fraction)? {
            Some(matrices) => mesh.to_skin(&matrices, out),
            None => Ok(()),
        }
    }

    /// Moves vertices that [`RenderMesh::deform`] made of a cloth to the skin, as far as the map `blend` of its bundle says, by the joints of
    /// the cloth at a fraction of the last step; [`Stepper::wrap`] and [`Stepper::record_wrap`] do that themselves. A cloth that does not follow
    /// joints is blended to where the source has it. Nothing happens without the map.
    ///
    /// Errors as [`RenderMesh::blend`], and if the cloth does not exist.
    pub fn blend(
        &self,
        cloth: impl Into<ClothRef>,
        mesh: &RenderMesh,
        fraction: f32,
        vertices: &mut [RenderVertex],
    ) -> Result<()> {
        let cloth = self.world.find(cloth.into())?;
        match self.skin_of(cloth, mesh, fraction)? {
            Some(matrices) => mesh.to_skin(&matrices, vertices),
            None => Ok(()),
        }
    }

    /// The matrices of the joints of a cloth at a fraction of the last step; `None` for a mesh that does not blend.
    fn skin_of(&self, cloth: usize, mesh: &RenderMesh, fraction: f32) -> Result<Option<Vec<Rows>>> {
        let Some(blended) = &mesh.blended else { return Ok(None) };
        let joints = self.world.runs[cloth].joints.as_ref();
        blended.matrices(joints.map(|joints| joints.at(fraction))).map(Some)
    }

    /// Records that the vertices of a mesh that is bound to a cloth, as [`Stepper::wrap`], are made at that place of the encoder: after
    /// [`Stepper::record`], with [`crate::Options::normals`] on. Returns where they lie: a [`RenderVertex`] of 48 bytes each, in a
    /// buffer for storage and vertices that stays until the call has another mesh.
    ///
    /// One dispatch for all vertices of the cloth, and one for those that blend to the skin, if there are any. The first call makes two
    /// buffers, 112 bytes per vertex, and one of 80 bytes per blended vertex with up to four joints. A frame without a call has no
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
            let matrices = stepper.skin_of(cloth, mesh, fraction)?;
            let gpu = stepper.gpu.as_mut().ok_or(Error::NoGpu("Stepper::record_wrap"))?;
            let span = gpu.vertices(&stepper.world, cloth, mesh)?;
            match stepper.cpu {
                Some(_) => gpu.upload_wrap(&span, &made),
                None => {
                    gpu.record_wrap(&stepper.world, encoder, cloth, fraction);
                    if let Some(matrices) = matrices {
                        gpu.record_blend(&stepper.world, encoder, cloth, mesh, &matrices);
                    }
                }
            }
            Ok(span)
        })
    }
}
