//! Tangents on the device, made when they are asked for.

use bytemuck::cast_slice;
use wgpu::BufferUsages;

use super::span::Span;
use super::upload::{DRAWN, upload};
use super::{Gpu, Offsets, begin};
use crate::form::Form;
use crate::passes::Pass;
use crate::shaders::Slot;
use crate::world::World;

impl Gpu {
    /// Records the tangents of a cloth, and returns where they lie.
    pub fn record_tangents(&mut self, world: &World, encoder: &mut wgpu::CommandEncoder, cloth: usize) -> Span {
        let of = &world.scene.cloths[cloth];
        let span = self.tangents(cloth);
        let buffers = &mut self.cloths[cloth];
        buffers.follow_grids(&self.device, world, cloth);
        let charts = || upload(&self.device, "charts", world.runs[cloth].charts(of), BufferUsages::empty()).into();
        buffers.others.entry(Slot::Charts).or_insert_with(charts);
        let what = Form::Apart(Pass::Tangents { holes: of.is_cut() });
        self.run(of, &mut begin(encoder, "tangents"), cloth, (&what, Offsets::default()));
        span
    }

    /// Uploads the tangents of a cloth that the CPU steps.
    pub fn upload_tangents(&mut self, cloth: usize, made: &[[f32; 4]]) -> Span {
        let span = self.tangents(cloth);
        self.writer.write(&span.buffer, span.offset, cast_slice(made));
        span
    }

    /// Where they lie.
    fn tangents(&mut self, cloth: usize) -> Span {
        let buffers = &mut self.cloths[cloth];
        let none = || vec![[0f32; 4]; (buffers.now.size / 16) as usize];
        buffers.tangents.get_or_insert_with(|| upload(&self.device, "tangents", &none(), DRAWN).into()).clone()
    }
}
