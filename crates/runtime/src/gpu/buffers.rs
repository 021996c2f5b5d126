//! The buffers of a cloth.

use std::collections::HashMap;
use std::mem::offset_of;

use wgpu::{Buffer, BufferUsages};

use crate::cloth::{Cloth, Rest, Tethers};
use crate::gpu::contact;
use crate::gpu::contents::{Contents, Grids};
use crate::gpu::cut_tethers;
use crate::gpu::levels;
use crate::gpu::pipelines::Pipeline;
use crate::gpu::span::Span;
use crate::gpu::store::State;
use crate::gpu::turns;
use crate::gpu::upload::{empty, upload};
use crate::gpu::worn::Worn;
use crate::gpu::wrap::Wrapping;
use crate::gpu::wrap_indices::Remaining;
use crate::layout::FaultRow;
use crate::options::Options;
use crate::passes::has_levels;
use crate::shaders::{Bound, SCRATCH, Slot, Source};
use crate::world::World;

/// The buffers of a cloth for a vertex shader: arrays of `vec4<f32>`, one per particle, in buffers for storage and vertices
/// that cloths may share.
pub struct ClothBuffers {
    /// Positions \[m\] now; w is 1/mass, 0 for pinned, -1 for no particle.
    pub now: Span,
    /// Positions one step before. A vertex lies at `mix(before, now, fraction)`.
    pub before: Span,
    /// Unit normals at `now`, 0 where there is none; w is their weight.
    pub normals: Span,
    /// Triangles that a cut has taken away, a u32 a texel in a buffer for storage; none until the first cut. The quad of
    /// four particles with its upper left one at texel (i, j) has two triangles: bit 0 is (i, j), (i, j + 1),
    /// (i + 1, j + 1), bit 1 is (i, j), (i + 1, j + 1), (i + 1, j). A quad of three particles has one, bit 0.
    pub holes: Option<Span>,
    /// Eight u32 in a buffer for storage: particles at fault in the last frame, frames taken back, one more than the last
    /// particle at fault, and what is unused to a host. None for the classic solver and where the CPU steps.
    pub faults: Option<Span>,
    /// The triangles, once [`crate::Stepper::index_buffer`] has asked for them: six `u32` per texel in an index buffer.
    pub indices: Option<Span>,
    /// Whether triangles have changed since these were written.
    pub(super) reindex: bool,
    /// Unit tangents, once [`crate::Stepper::record_tangents`] has asked for them: those of the positions at its last call.
    pub tangents: Option<Span>,
    /// Of the mesh that is bound to it, once a host has asked for its vertices.
    pub(super) wrapping: Option<Wrapping>,
    /// The triangles of such a mesh, once a host has asked for them.
    pub(super) remaining: Option<Remaining>,
    stepping: bool,
    /// Whether it has what only passes of its own need.
    separate: bool,
    /// Whether lists that cuts change differ from those that whole frames read.
    pub(super) stale: bool,
    /// Of the grids in `others`.
    grids: Option<Grids>,
    /// Of cloth that is worn on the surface of a body, once a frame was recorded.
    pub(super) worn: Option<Worn>,
    /// All else that is bound.
    pub(super) others: HashMap<Slot, Span>,
    /// By what they bind, and by `turned`.
    groups: HashMap<Vec<Bound>, Vec<([bool; 4], wgpu::BindGroup)>>,
    /// Pins between coarse texels and where they lie beside them, for each level that is finer than the present one.
    pub(super) beside: Vec<Span>,
    /// Which of [`turns::TURNS`] lie in the other buffers, as they do after an odd number of tiles.
    pub(super) turned: [bool; 4],
}

/// Buffers that no cut changes.
const KEPT: [Slot; 9] = [
    Slot::Good,
    Slot::Lost,
    Slot::Solids,
    Slot::Bounds,
    Slot::Charts,
    Slot::Influences,
    Slot::Skinned,
    Slot::BackInfluences,
    Slot::BackSkinned,
];

impl ClothBuffers {
    /// Those of a cloth whose state lies in a store.
    pub(super) fn new(state: State<Span>, stepping: bool) -> Self {
        let State { now, before, normals, mut others } = state;
        ClothBuffers {
            now,
            before,
            normals,
            holes: None,
            indices: None,
            reindex: false,
            tangents: None,
            wrapping: None,
            remaining: None,
            faults: others.remove(&Slot::Faults),
            stepping,
            separate: false,
            stale: false,
            grids: None,
            worn: None,
            others,
            groups: HashMap::new(),
            beside: Vec::new(),
            turned: [false; 4],
        }
    }

    /// Whether the device steps it.
    pub(super) fn is_stepping(&self) -> bool {
        self.stepping
    }

    /// Whether it has what only passes of its own need.
    pub(super) fn is_separate(&self) -> bool {
        self.separate
    }

    /// Makes what only passes of the cloth's own need, once; its grids again where the bound of diagonals is another.
    pub(super) fn separate(&mut self, device: &wgpu::Device, world: &World, index: usize) {
        let (cloth, options) = (&world.scene.cloths[index], &world.control.options);
        if !self.stepping {
            return;
        }
        self.follow_grids(device, world, index);
        if std::mem::replace(&mut self.separate, true) {
            return;
        }
        let contents = Contents::new(world, &[index]);
        for (slot, buffer) in contents.upload(device).into_iter().filter(|(slot, _)| *slot != Slot::Holes) {
            // Rest lengths may be there already, and be cut.
            self.others.entry(slot).or_insert(buffer.into());
        }
        self.take(contents.nodes(device).map(|nodes| (Slot::Nodes, nodes)));
        if cloth.contact.is_some() {
            self.take(contact::buffers(device, cloth, options.thickness));
        }
    }

    /// Uploads its grids, where they are not those of the steps now.
    pub(super) fn follow_grids(&mut self, device: &wgpu::Device, world: &World, index: usize) {
        if let Some(rows) = Grids::follow(&mut self.grids, world, [(index, 0, 0)].into_iter()) {
            self.others.insert(Slot::Grids, upload(device, "grids", &rows, BufferUsages::empty()).into());
            self.forget(Slot::Grids);
        }
    }

    /// The bindings of a shader, made once.
    pub(super) fn group(&mut self, device: &wgpu::Device, pipeline: &Pipeline) -> &wgpu::BindGroup {
        self.make_scratch(device, &pipeline.source);
        let (bindings, turned) = (&pipeline.source.bindings, self.turned);
        let at = |groups: &Vec<([bool; 4], wgpu::BindGroup)>| groups.iter().position(|(t, _)| *t == turned);
        let at = self.groups.get(bindings).and_then(at).unwrap_or_else(|| {
            let group = self.bind(device, pipeline, &[]);
            let groups = self.groups.entry(bindings.clone()).or_default();
            groups.push((turned, group));
            groups.len() - 1
        });
        &self.groups[bindings][at].1
    }

    /// Buffers that only some scenes need: air that acts on triangles, multipliers of several relaxations,
    /// speeds of cloth that may fall asleep, its stretch where substeps are chosen by it.
    fn make_scratch(&mut self, device: &wgpu::Device, source: &Source) {
        let particles = self.now.size / 16;
        for slot in source.bindings.iter().map(|b| b.slot) {
            let size = match slot {
                slot if SCRATCH.contains(&slot) => particles * 16,
                Slot::Next | Slot::Passed | Slot::Losing | Slot::Summing => particles * 16,
                Slot::Partial => particles.div_ceil(64) * 4,
                Slot::Fastest | Slot::Strain => 4,
                _ => continue,
            };
            let usage = BufferUsages::STORAGE | BufferUsages::COPY_SRC | BufferUsages::COPY_DST;
            self.others.entry(slot).or_insert_with(|| empty(device, slot.name(), size, usage).into());
        }
    }

    /// Bindings of a shader, `more` being what is not the cloth's own.
    pub(super) fn bind(&self, device: &wgpu::Device, pipeline: &Pipeline, more: &[(Slot, &Span)]) -> wgpu::BindGroup {
        pipeline.bind(device, |slot| match turns::lies(self.turned, slot) {
            Slot::Now => Some(self.now.binding()),
            Slot::Before => Some(self.before.binding()),
            Slot::Normals => Some(self.normals.binding()),
            Slot::Holes => self.holes.as_ref().map(Span::binding),
            Slot::Indices => self.indices.as_ref().map(Span::binding),
            Slot::Tangents => self.tangents.as_ref().map(Span::binding),
            Slot::Faults => self.faults.as_ref().map(Span::binding),
            other => match more.iter().find(|m| m.0 == other) {
                Some((_, span)) => Some(span.binding()),
                None => self.others.get(&other).map(Span::binding),
            },
        })
    }

    /// Makes room for cuts: no triangle is missing yet, and rest lengths are an image.
    pub(super) fn open(&mut self, device: &wgpu::Device, cloth: &Cloth, held: &Tethers, options: &Options) {
        self.stale = true;
        if self.holes.is_none() {
            if self.stepping {
                self.take(cut_tethers::room(device, cloth, held));
            }
            let none = vec![0u32; cloth.len()];
            self.holes = Some(upload(device, "holes", &none, BufferUsages::COPY_SRC).into());
        }
        if let (Rest::Image(rest), true) = (cloth.rest(), self.stepping) {
            let new = || upload(device, "rest", rest, BufferUsages::empty()).into();
            self.others.entry(Slot::Rest).or_insert_with(new);
        }
        if has_levels(cloth, options) && self.stepping {
            self.others.entry(Slot::Links).or_insert_with(|| levels::links(device, cloth).into());
        }
    }

    /// Drops what cuts have changed, and what is made beside it: both are made again when they are needed.
    pub(super) fn mend(&mut self) {
        (self.holes, self.separate, self.grids) = (None, false, None);
        self.others.retain(|slot, _| KEPT.contains(slot));
        self.groups.clear();
    }

    fn take(&mut self, buffers: impl IntoIterator<Item = (Slot, Buffer)>) {
        self.others.extend(buffers.into_iter().map(|(slot, buffer)| (slot, buffer.into())));
    }

    /// A buffer of the cloth's own.
    pub(super) fn other(&self, slot: Slot) -> Option<&Buffer> {
        self.others.get(&slot).map(|span| &span.buffer)
    }

    /// The largest squared displacement of the last frame, where cloth may fall asleep.
    pub(super) fn fastest(&self, shared: bool) -> Option<(&Buffer, u64)> {
        if shared {
            return self.faults.as_ref().map(|f| (&f.buffer, f.offset + offset_of!(FaultRow, speed) as u64));
        }
        self.other(Slot::Fastest).map(|b| (b, 0))
    }

    /// The largest residual of springs in the last frame, where that is measured.
    pub(super) fn strain(&self, shared: bool) -> Option<(&Buffer, u64)> {
        if shared {
            return self.faults.as_ref().map(|f| (&f.buffer, f.offset + offset_of!(FaultRow, strain) as u64));
        }
        self.other(Slot::Strain).map(|b| (b, 0))
    }

    /// From here on a slot is this part of a buffer.
    pub(super) fn replace(&mut self, slot: Slot, span: Span) {
        if self.others.get(&slot) != Some(&span) {
            self.others.insert(slot, span);
            self.forget(slot);
        }
    }

    /// Drops the bindings that name the old buffer of a slot.
    pub(super) fn forget(&mut self, slot: Slot) {
        self.groups.retain(|bindings, _| bindings.iter().all(|b| b.slot != slot));
    }
}
