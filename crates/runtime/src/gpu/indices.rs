//! Index buffers on the device, made when they are asked for, and again after each cut.

use bytemuck::cast_slice;
use wgpu::BufferUsages;

use super::span::Span;
use super::upload::upload;
use super::wrap_indices::Remaining;
use super::{Gpu, begin};
use crate::cpu::body::Body;
use crate::passes::Pass;
use crate::shaders::source;
use crate::world::World;

impl Gpu {
    /// The index buffer of a cloth, and whether it has to be written again because the cloth is cut.
    pub fn index_buffer(&mut self, world: &World, cloth: usize) -> (Span, bool) {
        let (of, buffers) = (&world.scene.cloths[cloth], &mut self.cloths[cloth]);
        let mut new = false;
        let span = buffers.indices.get_or_insert_with(|| {
            new = true;
            upload(&self.device, "indices", &of.all_indices(&[]), BufferUsages::INDEX).into()
        });
        let span = span.clone();
        new &= of.is_cut();
        buffers.reindex |= new;
        (span, new)
    }

    /// Triangles of a cloth will be others when what waits for the next frame is done.
    pub fn forget_indices(&mut self, cloth: usize) {
        let buffers = &mut self.cloths[cloth];
        buffers.reindex = buffers.indices.is_some();
        buffers.remaining.iter_mut().for_each(Remaining::forget);
    }

    /// Records what writes the index buffers of cloths whose triangles have changed.
    pub(super) fn reindex(&mut self, world: &World, encoder: &mut wgpu::CommandEncoder) {
        let stale: Vec<usize> = (0..self.cloths.len()).filter(|c| self.cloths[*c].reindex).collect();
        if stale.is_empty() {
            return;
        }
        let mut pass = begin(encoder, "indices");
        for cloth in stale {
            let of = &world.scene.cloths[cloth];
            let what = Pass::Indices { holes: of.is_cut() };
            let groups = source(&what.into()).workgroups(of);
            self.once(world, &mut pass, cloth, what, &[], groups);
            self.cloths[cloth].reindex = false;
        }
    }

    /// Writes the index buffer of a cloth that the CPU steps, where its triangles have changed.
    pub fn upload_indices(&mut self, world: &World, cloth: usize, body: &Body<f32>) {
        let buffers = &mut self.cloths[cloth];
        let Some(span) = buffers.indices.as_ref().filter(|_| buffers.reindex) else { return };
        let indices = world.scene.cloths[cloth].all_indices(&body.holes);
        self.writer.write(&span.buffer, span.offset, cast_slice(&indices));
        buffers.reindex = false;
    }
}
