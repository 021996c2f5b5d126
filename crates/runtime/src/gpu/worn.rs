//! Cloth on the surface of a body, on the GPU: three dispatches before the steps of a frame find the planes that particles meet in it, which are copied
//! to the list that steps read.

use bytemuck::cast_slice;
use wgpu::BufferUsages;

use super::span::Span;
use super::upload::{empty, upload};
use super::{Gpu, begin};
use crate::cloth::surface::{BodySurface, NONE};
use crate::cloth::{Anchor, Cloth, Poses, Rows};
use crate::collider::FRICTION;
use crate::cpu::surface::contact::NOTHING;
use crate::cpu::surface::give::{SPAN, gives, spans};
use crate::cpu::surface::search::{SEARCH_FRAMES, beside};
use crate::passes::Pass;
use crate::shaders::{HINT_BYTES, PLANE_BYTES, Slot, VERTEX_BYTES, source};
use crate::world::World;

/// The surface that a cloth is worn on, and what its particles know of it.
pub(super) struct Worn {
    /// The buffers that the passes bind beside the positions and their numbers.
    spans: Vec<(Slot, Span)>,
    /// Frames since all particles searched among all patches.
    frames: u32,
    /// Whether they do so in the next one.
    afresh: bool,
}

impl Worn {
    fn new(device: &wgpu::Device, cloth: &Cloth, surface: &BodySurface, thickness: f32) -> Self {
        let none = BufferUsages::empty();
        let made = BufferUsages::STORAGE | BufferUsages::COPY_SRC;
        let room = |slot: Slot, bytes: usize| empty(device, slot.name(), bytes as u64, made);
        let spans = [
            (Slot::SurfaceShape, upload(device, "surface shape", &surface.shape(cloth.body_sets()), none)),
            (Slot::SurfaceTriangles, upload(device, "surface triangles", &surface.list(), none)),
            (Slot::SurfaceVertices, room(Slot::SurfaceVertices, surface.vertices() * VERTEX_BYTES)),
            (Slot::SurfaceBoxes, room(Slot::SurfaceBoxes, surface.patches() * 48)),
            (Slot::SurfaceHints, upload(device, "surface hints", &unknown(cloth), none)),
            (Slot::Wearers, upload(device, "wearers", &wearers(cloth, thickness), none)),
            (Slot::FoundPlanes, room(Slot::FoundPlanes, cloth.len() * PLANE_BYTES)),
        ];
        let spans = spans.into_iter().map(|(slot, buffer)| (slot, buffer.into())).collect();
        Worn { spans, frames: 0, afresh: true }
    }
}

/// The hints of particles that know no point yet. A frame that was recorded may never be submitted, so that they are there before.
fn unknown(cloth: &Cloth) -> Vec<[u32; 4]> {
    (0..HINT_BYTES / 16 * cloth.len()).map(|_| [0, 0, 0, NONE]).collect()
}

/// The constant numbers of the particles, as shaders/surface_search.wgsl reads them.
fn wearers(cloth: &Cloth, thickness: f32) -> Vec<[[u32; 4]; 4]> {
    let (points, clearances) = (cloth.points(), cloth.clearances(thickness));
    let [mut near, mut far] = [(); 2].map(|()| vec![[NONE; 4]; cloth.len()]);
    for grid in cloth.grids() {
        let (first, size) = (grid.first as usize, (grid.width as usize, grid.height as usize));
        for k in 0..size.0 * size.1 {
            for (all, cells) in [(&mut near, 1), (&mut far, SPAN)] {
                let other = |side| beside(k, size, cells, side).map_or(NONE, |n| points[first + n]);
                all[first + k] = [0, 1, 2, 3].map(other);
            }
        }
    }
    let (holds, spans) = (cloth.tethers(1).anchors, spans(cloth));
    let one = |point: &u32| {
        let k = *point as usize;
        let pin = holds.get(k).unwrap_or(&Anchor::NONE);
        let held = [clearances[k].to_bits(), *point, pin.particle, pin.distance.to_bits()];
        [held, near[k], far[k], spans[k].map(f32::to_bits)]
    };
    points.iter().map(one).collect()
}

/// The planes of a cloth whose particles meet none.
pub(super) fn none(cloth: &Cloth) -> Vec<[f32; 4]> {
    let each = PLANE_BYTES / 16;
    (0..each * cloth.len()).map(|n| [0.0, 0.0, 0.0, if n % (each / 2) == 0 { NOTHING as f32 } else { 0.0 }]).collect()
}

impl Gpu {
    /// Records the search of all cloths that are worn on surfaces, for a frame of `steps` steps.
    pub(super) fn wear(&mut self, world: &World, encoder: &mut wgpu::CommandEncoder, steps: u32) {
        // Scenes of a thousand cloths do not look at each.
        let count = if world.any_worn { self.cloths.len() } else { 0 };
        for cloth in 0..count {
            let (of, run) = (&world.scene.cloths[cloth], &world.runs[cloth]);
            if let (Some(surface), true) = (of.body(), steps > 0 && !run.asleep) {
                self.wear_one(world, encoder, cloth, (surface, steps));
            }
        }
    }

    fn wear_one(
        &mut self,
        world: &World,
        encoder: &mut wgpu::CommandEncoder,
        cloth: usize,
        (surface, steps): (&BodySurface, u32),
    ) {
        let (of, run) = (&world.scene.cloths[cloth], &world.runs[cloth]);
        if world.is_apart(cloth) {
            self.cloths[cloth].separate(&self.device, world, cloth);
        }
        let thickness = world.control.options.thickness;
        let known = self.cloths[cloth].worn.take();
        let mut worn = known.unwrap_or_else(|| Worn::new(&self.device, of, surface, thickness));
        let (from, to) = run.joints.as_ref().map_or((None, &[][..]), |joints| joints.ends());
        let rate = if from.is_some() { 1.0 / (f64::from(steps) * world.control.clock.dt) } else { 0.0 };
        let friction = (FRICTION * of.friction).min(f32::MAX);
        let frame = (worn.frames % SEARCH_FRAMES) as f32;
        let numbers = [
            [rate as f32, frame, f32::from(u8::from(worn.afresh)), 0.0],
            [surface.triangles().len() as f32, surface.patches() as f32, friction, f32::from(u8::from(gives(of)))],
        ];
        let numbers = self.list("surface", cast_slice(&numbers));
        let mut pass = begin(encoder, "surface");
        for what in &run.schedule.worn {
            let action = match what {
                Pass::SurfacePose { .. } => {
                    let poses = |rows: &[Rows]| Poses::<f32>::new(of.skinning, rows).list();
                    let mut list = poses(to);
                    list.extend(poses(from.unwrap_or(to)));
                    if list.is_empty() {
                        list.push([0.0; 4]);
                    }
                    self.list("poses", cast_slice(&list))
                }
                _ => numbers.clone(),
            };
            let own = worn.spans.iter().map(|(slot, span)| (*slot, span));
            let more: Vec<(Slot, &Span)> = own.chain([(Slot::Action, &action)]).collect();
            let groups = source(&(*what).into()).workgroups(of);
            self.once(world, &mut pass, cloth, *what, &more, groups);
        }
        drop(pass);
        for span in self.vectors(world, cloth, Slot::SurfacePlanes) {
            if let Some((_, found)) = worn.spans.iter().find(|(slot, _)| *slot == Slot::FoundPlanes) {
                encoder.copy_buffer_to_buffer(&found.buffer, found.offset, &span.buffer, span.offset, found.size);
            }
        }
        (worn.frames, worn.afresh) = (worn.frames.wrapping_add(1), false);
        self.cloths[cloth].worn = Some(worn);
    }

    /// Has the particles of a cloth search among all patches in the next frame, as they may be anywhere.
    pub(super) fn forget_surface(&mut self, cloth: usize) {
        if let Some(worn) = &mut self.cloths[cloth].worn {
            (worn.frames, worn.afresh) = (0, true);
        }
    }
}
