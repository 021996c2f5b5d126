//! Vertices of bound meshes on the device, made when they are asked for.

use std::sync::Arc;

use bytemuck::cast_slice;
use wgpu::BufferUsages;

use super::span::Span;
use super::upload::{DRAWN, empty, filled, upload};
use super::{Gpu, begin};
use crate::cloth::Rows;
use crate::error::{Error, Result};
use crate::layout::BoundRow;
use crate::passes::Pass;
use crate::render_mesh::{RenderMesh, RenderVertex};
use crate::shaders::{Slot, list};
use crate::world::World;

/// The buffers of the mesh that is bound to a cloth.
pub(super) struct Wrapping {
    /// The bindings that were uploaded: a mesh is known by them.
    rows: Arc<Vec<BoundRow>>,
    /// None where the CPU steps.
    bound: Option<Span>,
    /// The vertices that blend to the skin, as the pass reads them; made with the first of them.
    blending: Option<Span>,
    /// The last matrices of the joints for these, and the buffer that has them.
    matrices: Option<(Vec<Rows>, Span)>,
    vertices: Span,
    /// The last fraction of a step, and the buffer that has it.
    fraction: Option<(f32, Span)>,
}

impl Gpu {
    /// Where the vertices of a mesh lie; buffers are made if the cloth has those of another mesh, or none.
    pub fn vertices(&mut self, world: &World, cloth: usize, mesh: &RenderMesh) -> Result<Span> {
        if let Some(known) = self.cloths[cloth].wrapping.as_ref().filter(|w| Arc::ptr_eq(&w.rows, &mesh.rows)) {
            return Ok(known.vertices.clone());
        }
        let limits = self.device.limits();
        let (need, limit) =
            (64 * mesh.len() as u64, limits.max_storage_buffer_binding_size.min(limits.max_buffer_size));
        if need > limit {
            let cloth = world.scene.cloths[cloth].name().into();
            return Err(Error::Limit { cloth, buffer: "render mesh", need, limit });
        }
        let size = (size_of::<RenderVertex>() * mesh.len().max(1)) as u64;
        let usage = BufferUsages::STORAGE | BufferUsages::COPY_DST | DRAWN;
        let vertices: Span = empty(&self.device, "render mesh", size, usage).into();
        let bound = self.cloths[cloth]
            .is_stepping()
            .then(|| upload(&self.device, "bound vertices", &mesh.rows, BufferUsages::empty()).into());
        let rows = mesh.rows.clone();
        self.cloths[cloth].wrapping =
            Some(Wrapping { rows, bound, blending: None, matrices: None, vertices: vertices.clone(), fraction: None });
        Ok(vertices)
    }

    /// Records the pass for a cloth with such buffers.
    pub fn record_wrap(&mut self, world: &World, encoder: &mut wgpu::CommandEncoder, cloth: usize, fraction: f32) {
        let device = self.device.clone();
        let Some(wrapping) = &mut self.cloths[cloth].wrapping else { return };
        let Some(bound) = wrapping.bound.clone().filter(|_| !wrapping.rows.is_empty()) else { return };
        // A buffer that recorded frames may still read is not written again.
        if wrapping.fraction.as_ref().is_none_or(|f| f.0 != fraction) {
            let numbers = filled(&device, "fraction", cast_slice(&[fraction, 0.0, 0.0, 0.0]), BufferUsages::STORAGE);
            wrapping.fraction = Some((fraction, numbers.into()));
        }
        let Some((_, numbers)) = wrapping.fraction.clone() else { return };
        let (vertices, groups) = (wrapping.vertices.clone(), list(wrapping.rows.len()));
        let more = [(Slot::Action, &numbers), (Slot::BoundVertices, &bound), (Slot::Wrapped, &vertices)];
        self.once(world, &mut begin(encoder, "wrap"), cloth, Pass::Wrap, &more, groups);
    }

    /// Records the pass that moves the vertices of a mesh to the skin by these matrices of the joints, after [`Gpu::record_wrap`].
    pub fn record_blend(
        &mut self,
        world: &World,
        encoder: &mut wgpu::CommandEncoder,
        cloth: usize,
        mesh: &RenderMesh,
        matrices: &[Rows],
    ) {
        let device = self.device.clone();
        let (Some(blended), Some(wrapping)) = (&mesh.blended, &mut self.cloths[cloth].wrapping) else { return };
        let vertices = wrapping.vertices.clone();
        let made = || upload(&device, "blended vertices", &blended.list(), BufferUsages::empty()).into();
        let blending = wrapping.blending.get_or_insert_with(made).clone();
        // As for fractions.
        if wrapping.matrices.as_ref().is_none_or(|known| known.0 != matrices) {
            let numbers = filled(&device, "joints", cast_slice(matrices), BufferUsages::STORAGE);
            wrapping.matrices = Some((matrices.to_vec(), numbers.into()));
        }
        let Some((_, numbers)) = wrapping.matrices.clone() else { return };
        let more = [(Slot::Action, &numbers), (Slot::Blending, &blending), (Slot::Wrapped, &vertices)];
        let pass = Pass::Blend { sets: blended.sets as u32 };
        self.once(world, &mut begin(encoder, "blend"), cloth, pass, &more, list(blended.rows.len()));
    }

    /// Uploads the vertices of a cloth that the CPU steps.
    pub fn upload_wrap(&mut self, span: &Span, made: &[RenderVertex]) {
        self.writer.write(&span.buffer, span.offset, cast_slice(made));
    }
}
