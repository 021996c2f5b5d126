//! The mesh of the source of a cloth, moved with it.

use super::Stepper;
use crate::cloth::Rows;
use crate::cpu::wrap::{Jumps, Sheet};
use crate::error::{Error, Result, check};
#[cfg(feature = "gpu")]
use crate::gpu::Span;
use crate::handle::ClothRef;
use crate::render_mesh::{RenderMesh, RenderVertex};

impl Stepper {
    /// The vertices of a mesh that is bound to a cloth, between the positions one step before (`fraction` 0) and those now (1); normals and
    /// tangents are those now. CPU backend only: on the GPU backend [`Stepper::record_wrap`] has them on the device, and
    /// [`RenderMesh::deform`] makes them from positions that are read back. `out` gets one entry per vertex, and keeps its memory.
    ///
    /// On a coarser level ([`Stepper::set_level`]) vertices are bound to the coarser surface, at rest where the source has them as on the finest
    /// one. A change of level moves no vertex: the way that it would jump is lost in the quarter of a second after it. The first call on a
    /// level binds the vertices to it, 0.3 microseconds each. Cuts leave vertices where the cloth around them goes; [`Stepper::render_indices`]
    /// has the triangles that are left.
    ///
    /// Errors on the GPU backend, if the cloth does not exist, if the mesh belongs to another bundle, and if the fraction is not finite.
    pub fn wrap(
        &self,
        cloth: impl Into<ClothRef>,
        mesh: &RenderMesh,
        fraction: f32,
        out: &mut Vec<RenderVertex>,
    ) -> Result<()> {
        let cloth = self.world.find(cloth.into())?;
        let (bodies, threads) = self.cpu.as_ref().ok_or(Error::GpuOnly("Stepper::wrap"))?;
        let (body, name) = (&bodies[cloth], self.world.scene.cloths[cloth].name());
        let bound = mesh.binding.on(name, &self.world.steps(cloth))?;
        check_fraction(fraction)?;
        let time = self.world.time_at(fraction);
        let arrival = self.world.runs[cloth].arrival.as_ref().filter(|arrival| arrival.share(time) > 0.0);
        let rows = arrival.map(|arrival| arrival.jumps(threads, name, mesh, &bound)).transpose()?;
        let share = arrival.map_or(0.0, |arrival| arrival.share(time));
        let jumps = rows.as_ref().map(|rows| Jumps { rows, share });
        let normals = body.normals(threads);
        let sheet = Sheet { now: body.now(), before: body.before(), normals, fraction };
        bound.run(threads, name, (&sheet, jumps), out)?;
        match self.skin_of(cloth, mesh, fraction)? {
            Some(matrices) => mesh.to_skin(&matrices, self.world.scene.cloths[cloth].skinning, out),
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
            Some(matrices) => mesh.to_skin(&matrices, self.world.scene.cloths[cloth].skinning, vertices),
            None => Ok(()),
        }
    }

    /// The matrices of the joints of a cloth at a fraction of the last step; `None` for a mesh that does not blend.
    fn skin_of(&self, cloth: usize, mesh: &RenderMesh, fraction: f32) -> Result<Option<Vec<Rows>>> {
        let Some(blended) = &mesh.blended else { return Ok(None) };
        let joints = self.world.runs[cloth].joints.as_ref();
        blended.matrices(joints.map(|joints| joints.at(fraction))).map(Some)
    }

    /// The triangles of a mesh that is bound to a cloth, without those that cuts have taken away: as [`RenderMesh::indices_left`], on the level
    /// that the cloth is on. `holes` as [`Stepper::holes`], or read back from [`crate::ClothBuffers::holes`]; empty for cloth that is
    /// whole.
    ///
    /// Errors as there, and if the cloth does not exist.
    pub fn render_indices(&self, cloth: impl Into<ClothRef>, mesh: &RenderMesh, holes: &[u32]) -> Result<Vec<u32>> {
        let cloth = self.world.find(cloth.into())?;
        let of = &self.world.scene.cloths[cloth];
        mesh.left(&*mesh.binding.on(of.name(), &self.world.steps(cloth))?, of, holes)
    }

    /// Records that the vertices of a mesh that is bound to a cloth, as [`Stepper::wrap`], are made at that place of the encoder: after
    /// [`Stepper::record`], with [`crate::Options::normals`] on. Returns where they lie: a [`RenderVertex`] of 48 bytes each, in a
    /// buffer for storage and vertices that stays until the call has another mesh.
    ///
    /// One dispatch for all vertices of the cloth, and one for those that blend to the skin, if there are any. The first call makes two
    /// buffers, 112 bytes per vertex, and one of 80 bytes per blended vertex with up to four joints. A frame without a call has no
    /// cost, and a cloth without a call has no buffers. On the CPU backend they are made at once and uploaded. A change of level of a cloth whose
    /// vertices were made adds two dispatches, and 48 bytes per vertex until its jumps are lost.
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
        let bound = mesh.binding.on(of.name(), &self.world.steps(cloth))?;
        bound.fits(of.name(), of.len())?;
        check_fraction(fraction)?;
        self.guarded(|stepper| {
            let mut made = Vec::new();
            if stepper.cpu.is_some() {
                stepper.wrap(cloth, mesh, fraction, &mut made)?;
            }
            let matrices = stepper.skin_of(cloth, mesh, fraction)?;
            let gpu = stepper.gpu.as_mut().ok_or(Error::NoGpu("Stepper::record_wrap"))?;
            let span = gpu.vertices(&stepper.world, cloth, &mesh.binding, &bound)?;
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

    /// The triangles of a mesh that is bound to a cloth in an index buffer on the device (`Uint32`), as [`Stepper::render_indices`]: the ranges of
    /// the parts are those of [`RenderMesh::indices`], and triangles that a cut has taken away are points. Made by the first call, 8 bytes per
    /// index and 8 per pair of a triangle of the mesh and one of the cloth that it covers. One copy and one dispatch follow each cut
    /// and each state that is loaded; no other frame has any cost. A cloth that is cut already has its holes from the next frame on. The
    /// buffer stays until the cloth changes its level or the call has another mesh.
    ///
    /// Errors as [`Stepper::record_wrap`].
    #[cfg(feature = "gpu")]
    pub fn render_index_buffer(&mut self, cloth: impl Into<ClothRef>, mesh: &RenderMesh) -> Result<Span> {
        let cloth = self.world.find(cloth.into())?;
        let of = &self.world.scene.cloths[cloth];
        let bound = mesh.binding.on(of.name(), &self.world.steps(cloth))?;
        bound.fits(of.name(), of.len())?;
        self.guarded(|stepper| {
            let gpu = stepper.gpu.as_mut().ok_or(Error::NoGpu("Stepper::render_index_buffer"))?;
            let (span, new) = gpu.render_index_buffer(&stepper.world, cloth, mesh, &bound)?;
            stepper.world.host.touched |= new;
            Ok(span)
        })
    }
}

fn check_fraction(fraction: f32) -> Result<()> {
    check("the fraction of the last step", fraction.into(), "finite", f64::is_finite)
}
