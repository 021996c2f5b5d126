//! Vertices of bound meshes on the device, made when they are asked for.

use std::sync::Arc;

use bytemuck::cast_slice;
use wgpu::BufferUsages;

use super::span::Span;
use super::upload::{DRAWN, empty, filled, upload};
use super::{Gpu, begin};
use crate::cloth::{Poses, Rows};
use crate::error::{Error, Result};
use crate::layout::JumpRow;
use crate::passes::Pass;
use crate::render_mesh::{Binding, Bound, RenderMesh, RenderVertex};
use crate::shaders::{Slot, list, source};
use crate::world::World;
use crate::world::arrival::share;

/// The buffers of the mesh that is bound to a cloth.
pub(super) struct Wrapping {
    /// The bindings of the mesh: it is known by them.
    binding: Arc<Binding>,
    /// That to the level of the cloth.
    level: Arc<Bound>,
    /// Its rows. None where the CPU steps.
    bound: Option<Span>,
    /// How far the vertices would have jumped at a change of level, and when that was \[s\].
    jumps: Option<(Span, f64)>,
    /// The vertices that blend to the skin, as the pass reads them; made with the first of them.
    blending: Option<Span>,
    /// The last matrices of the joints for these, and the buffer that has them.
    matrices: Option<(Vec<Rows>, Span)>,
    vertices: Span,
    /// The last fraction of a step and share of the jumps, and the buffer that has them.
    numbers: Option<([f32; 2], Span)>,
}

impl Gpu {
    /// Where the vertices of a mesh lie; buffers are made if the cloth has those of another mesh, or none.
    pub fn vertices(
        &mut self,
        world: &World,
        cloth: usize,
        binding: &Arc<Binding>,
        level: &Arc<Bound>,
    ) -> Result<Span> {
        if let Some(known) = self.cloths[cloth].wrapping.as_ref().filter(|w| Arc::ptr_eq(&w.level, level)) {
            return Ok(known.vertices.clone());
        }
        let (limits, count) = (self.device.limits(), level.rows.len());
        let (need, limit) = (64 * count as u64, limits.max_storage_buffer_binding_size.min(limits.max_buffer_size));
        if need > limit {
            let cloth = world.scene.cloths[cloth].name().into();
            return Err(Error::Limit { cloth, buffer: "render mesh", need, limit });
        }
        let size = (size_of::<RenderVertex>() * count.max(1)) as u64;
        let usage = BufferUsages::STORAGE | BufferUsages::COPY_DST | DRAWN;
        let vertices: Span = empty(&self.device, "render mesh", size, usage).into();
        let (binding, level, bound) = (binding.clone(), level.clone(), self.bound_rows(cloth, level));
        let wrapping = Wrapping {
            binding,
            level,
            bound,
            jumps: None,
            blending: None,
            matrices: None,
            vertices: vertices.clone(),
            numbers: None,
        };
        self.cloths[cloth].wrapping = Some(wrapping);
        Ok(vertices)
    }

    /// The rows of a binding for shaders; none where the CPU steps.
    fn bound_rows(&self, cloth: usize, level: &Bound) -> Option<Span> {
        let stepping = self.cloths[cloth].is_stepping();
        stepping.then(|| upload(&self.device, "bound vertices", &level.rows, BufferUsages::empty()).into())
    }

    /// Records the pass for a cloth with such buffers.
    pub fn record_wrap(&mut self, world: &World, encoder: &mut wgpu::CommandEncoder, cloth: usize, fraction: f32) {
        let device = self.device.clone();
        let Some(wrapping) = &mut self.cloths[cloth].wrapping else { return };
        let Some(bound) = wrapping.bound.clone().filter(|_| !wrapping.level.rows.is_empty()) else { return };
        let share = wrapping.jumps.as_ref().map_or(0.0, |(_, since)| share(world.time_at(fraction) - since));
        if share == 0.0 {
            // Fractions go back and forth in a step, so jumps stay until none of the last one shows them.
            wrapping.jumps.take_if(|(_, since)| self::share(world.time_at(0.0) - *since) == 0.0);
        }
        let jumps = wrapping.jumps.as_ref().filter(|_| share > 0.0).map(|(span, _)| span.clone());
        let numbers = wrapping.numbers(&device, [fraction, share]);
        let (vertices, groups) = (wrapping.vertices.clone(), list(wrapping.level.rows.len()));
        let mut more = vec![(Slot::Action, &numbers), (Slot::BoundVertices, &bound), (Slot::Wrapped, &vertices)];
        more.extend(jumps.as_ref().map(|span| (Slot::Jumps, span)));
        let pass = Pass::Wrap { jumps: jumps.is_some() };
        self.once(world, &mut begin(encoder, "wrap"), cloth, pass, &more, groups);
    }

    /// Records where the vertices of a cloth are that is about to change its level: at its positions now, on the cloth alone.
    pub fn record_departure(&mut self, world: &World, encoder: &mut wgpu::CommandEncoder, cloth: usize) {
        self.record_wrap(world, encoder, cloth, 1.0);
    }

    /// Records how far these vertices would jump, now that the cloth is on its new level. Errors if that is not one of the bundle of the mesh.
    pub fn record_arrival(&mut self, world: &World, encoder: &mut wgpu::CommandEncoder, cloth: usize) -> Result<()> {
        let of = &world.scene.cloths[cloth];
        let Some(binding) = self.cloths[cloth].wrapping.as_ref().map(|w| w.binding.clone()) else { return Ok(()) };
        let level = binding.on(of.name(), &world.steps(cloth))?;
        let bound = self.bound_rows(cloth, &level);
        let device = self.device.clone();
        // The new level has no normals yet.
        let drawn = |p: &&Pass| matches!(p, Pass::Normals { .. } | Pass::SeamNormals);
        let passes: Vec<Pass> = world.runs[cloth].schedule.frame.iter().filter(drawn).copied().collect();
        let mut pass = begin(encoder, "arrival");
        let is_separate = self.cloths[cloth].is_separate();
        for what in passes {
            let groups = source(&what.into()).workgroups(of);
            self.once(world, &mut pass, cloth, what, &[], groups);
        }
        if !is_separate {
            // Cloths that share dispatches have no lists of their own.
            self.cloths[cloth].mend();
        }
        let Some(wrapping) = &mut self.cloths[cloth].wrapping else { return Ok(()) };
        (wrapping.level, wrapping.bound, wrapping.jumps) = (level, bound, None);
        let Some(bound) = wrapping.bound.clone().filter(|_| !wrapping.level.rows.is_empty()) else { return Ok(()) };
        let (numbers, vertices) = (wrapping.numbers(&device, [1.0, 0.0]), wrapping.vertices.clone());
        let count = wrapping.level.rows.len();
        let size = (size_of::<JumpRow>() * count) as u64;
        let jumps: Span = empty(&device, "jumps", size, BufferUsages::STORAGE).into();
        wrapping.jumps = Some((jumps.clone(), world.time_at(1.0)));
        let more = [
            (Slot::Action, &numbers),
            (Slot::BoundVertices, &bound),
            (Slot::Wrapped, &vertices),
            (Slot::Jumps, &jumps),
        ];
        self.once(world, &mut pass, cloth, Pass::Jump, &more, list(count));
        Ok(())
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
        let skinning = world.scene.cloths[cloth].skinning;
        if wrapping.matrices.as_ref().is_none_or(|known| known.0 != matrices) {
            let list = Poses::new(skinning, matrices).list();
            let numbers = filled(&device, "joints", cast_slice(&list), BufferUsages::STORAGE);
            wrapping.matrices = Some((matrices.to_vec(), numbers.into()));
        }
        let Some((_, numbers)) = wrapping.matrices.clone() else { return };
        let more = [(Slot::Action, &numbers), (Slot::Blending, &blending), (Slot::Wrapped, &vertices)];
        let pass = Pass::Blend { sets: blended.sets as u32, skinning };
        self.once(world, &mut begin(encoder, "blend"), cloth, pass, &more, list(blended.rows.len()));
    }

    /// Uploads the vertices of a cloth that the CPU steps.
    pub fn upload_wrap(&mut self, span: &Span, made: &[RenderVertex]) {
        self.writer.write(&span.buffer, span.offset, cast_slice(made));
    }
}

impl Wrapping {
    /// A buffer with a fraction of a step and a share of the jumps. One that recorded frames may still read is not written again.
    fn numbers(&mut self, device: &wgpu::Device, numbers: [f32; 2]) -> Span {
        match &self.numbers {
            Some((known, span)) if *known == numbers => span.clone(),
            _ => {
                let list = [numbers[0], numbers[1], 0.0, 0.0];
                let span: Span = filled(device, "fraction", cast_slice(&list), BufferUsages::STORAGE).into();
                self.numbers = Some((numbers, span.clone()));
                span
            }
        }
    }
}
