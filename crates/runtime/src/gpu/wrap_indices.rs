//! Index buffers of bound meshes on the device, made when they are asked for, and written again after each cut.

use std::sync::Arc;

use bytemuck::cast_slice;
use wgpu::BufferUsages;

use super::span::Span;
use super::upload::upload;
use super::{Gpu, begin};
use crate::cpu::body::Body;
use crate::cpu::wrap_indices;
use crate::error::{Error, Result};
use crate::passes::Pass;
use crate::render_mesh::{Bound, Covers, RenderMesh};
use crate::shaders::{Slot, list};
use crate::world::World;

/// The triangles of a mesh that are left.
pub(super) struct Remaining {
    /// A mesh and a level are known by it.
    bound: Arc<Bound>,
    lists: Lists,
    indices: Span,
    /// Whether triangles of the cloth have changed since these were written.
    stale: bool,
}

/// The triangles of the mesh, and those of the cloth that each covers.
enum Lists {
    Device {
        whole: Span,
        covers: Span,
        count: usize,
    },
    /// Where the CPU steps.
    Host {
        whole: Vec<u32>,
        covers: Arc<Covers>,
    },
}

impl Gpu {
    /// The index buffer of a mesh, and whether the next frame has to write it because the cloth is cut.
    pub fn render_index_buffer(
        &mut self,
        world: &World,
        cloth: usize,
        mesh: &RenderMesh,
        bound: &Arc<Bound>,
    ) -> Result<(Span, bool)> {
        let of = &world.scene.cloths[cloth];
        if let Some(known) = self.cloths[cloth].remaining.as_ref().filter(|known| Arc::ptr_eq(&known.bound, bound)) {
            return Ok((known.indices.clone(), false));
        }
        let covers = bound.covers(of, &mesh.indices);
        let limits = self.device.limits();
        let need = (4 * mesh.indices.len() as u64).max(8 * covers.0.len() as u64);
        let limit = limits.max_storage_buffer_binding_size.min(limits.max_buffer_size);
        if need > limit {
            return Err(Error::Limit { cloth: of.name().into(), buffer: "render indices", need, limit });
        }
        // A buffer without bytes cannot be bound.
        let whole = if mesh.indices.is_empty() { vec![0; 3] } else { mesh.indices.clone() };
        let indices: Span = upload(&self.device, "render indices", &whole, BufferUsages::INDEX).into();
        let lists = if self.cloths[cloth].is_stepping() {
            let pairs = if covers.0.is_empty() { &[[0; 2]][..] } else { &covers.0 };
            Lists::Device {
                whole: upload(&self.device, "whole render indices", &whole, BufferUsages::empty()).into(),
                covers: upload(&self.device, "covers", pairs, BufferUsages::empty()).into(),
                count: covers.0.len(),
            }
        } else {
            Lists::Host { whole, covers }
        };
        let stale = of.is_cut();
        self.cloths[cloth].remaining = Some(Remaining { bound: bound.clone(), lists, indices: indices.clone(), stale });
        Ok((indices, stale))
    }

    /// Records what writes the index buffers of meshes whose cloths have other triangles than before.
    pub(super) fn rewrap(&mut self, world: &World, encoder: &mut wgpu::CommandEncoder) {
        for cloth in 0..self.cloths.len() {
            let Some(remaining) = self.cloths[cloth].remaining.as_mut().filter(|r| r.stale) else { continue };
            let Lists::Device { whole, covers, count } = &remaining.lists else { continue };
            let (indices, whole, covers, count) = (remaining.indices.clone(), whole.clone(), covers.clone(), *count);
            remaining.stale = false;
            encoder.copy_buffer_to_buffer(&whole.buffer, whole.offset, &indices.buffer, indices.offset, whole.size);
            if world.scene.cloths[cloth].is_cut() && count > 0 {
                let more = [(Slot::Covers, &covers), (Slot::MeshIndices, &whole), (Slot::LeftIndices, &indices)];
                let mut pass = begin(encoder, "wrap indices");
                self.once(world, &mut pass, cloth, Pass::WrapIndices, &more, list(count));
            }
        }
    }

    /// Writes the index buffer of a mesh whose cloth the CPU steps, where its triangles have changed.
    pub fn upload_render_indices(&mut self, cloth: usize, body: &Body<f32>) {
        let Some(remaining) = self.cloths[cloth].remaining.as_mut().filter(|r| r.stale) else { return };
        let Lists::Host { whole, covers } = &remaining.lists else { return };
        let mut left = whole.clone();
        if body.is_cut() {
            wrap_indices::run(&covers.0, &body.holes, &mut left);
        }
        remaining.stale = false;
        let span = &remaining.indices;
        self.writer.write(&span.buffer, span.offset, cast_slice(&left));
    }
}

impl Remaining {
    /// Triangles of the cloth will be others.
    pub fn forget(&mut self) {
        self.stale = true;
    }
}
