//! Putting particles in their places on the GPU: pins, from the host's memory or from a buffer on the device.

use bytemuck::cast_slice;
use wgpu::{BufferBinding, BufferUsages};

use super::span::Span;
use super::upload::filled;
use super::{Gpu, begin};
use crate::cpu::place::{PLACE_MOVES, PLACE_WEIGHS, Placed, merged};
use crate::passes::Pass;
use crate::shaders::{Slot, list};

impl Gpu {
    /// Records that particles are put in their places: two lists, and a dispatch.
    pub(super) fn place(&mut self, pass: &mut wgpu::ComputePass, cloth: usize, rows: &[Placed]) {
        let rows = merged(rows);
        let flags = |row: &Placed| {
            let moves = if row.at.is_some() { PLACE_MOVES } else { 0 };
            moves | if row.inverse_mass.is_some() { PLACE_WEIGHS } else { 0 }
        };
        let chosen: Vec<_> = rows.iter().zip(0u32..).map(|(row, n)| [row.particle | flags(row), n]).collect();
        let vector = |row: &Placed| {
            let [x, y, z] = row.at.unwrap_or_default();
            [x, y, z, row.inverse_mass.unwrap_or_default()]
        };
        let at: Vec<_> = rows.iter().map(vector).collect();
        let at = self.list("places", cast_slice(&at));
        let list = self.list("chosen", cast_slice(&chosen));
        self.scatter(pass, cloth, (&list, chosen.len()), at.binding());
    }

    /// Records that particles are put at positions that lie in a buffer; for each particle the place in it.
    pub fn place_from(
        &mut self,
        encoder: &mut wgpu::CommandEncoder,
        cloth: usize,
        particles: &[[u32; 2]],
        positions: &Span,
    ) {
        let chosen: Vec<_> = particles.iter().map(|[k, n]| [k | PLACE_MOVES, *n]).collect();
        let mut pass = begin(encoder, "pins");
        let list = filled(&self.device, "chosen", cast_slice(&chosen), BufferUsages::STORAGE).into();
        self.scatter(&mut pass, cloth, (&list, chosen.len()), positions.binding());
    }

    fn scatter(
        &mut self,
        pass: &mut wgpu::ComputePass,
        cloth: usize,
        (chosen, count): (&Span, usize),
        places: BufferBinding,
    ) {
        let pipeline = self.pipelines.get(&Pass::Place.into());
        let buffers = &self.cloths[cloth];
        let group = pipeline.bind(&self.device, |slot| match slot {
            Slot::Now => Some(buffers.now.binding()),
            Slot::Before => Some(buffers.before.binding()),
            Slot::Action => Some(places.clone()),
            Slot::Chosen => Some(chosen.binding()),
            _ => None,
        });
        let [x, y, z] = list(count);
        pass.set_pipeline(&pipeline.pipeline);
        pass.set_bind_group(0, &group, &[]);
        pass.dispatch_workgroups(x, y, z);
    }
}
