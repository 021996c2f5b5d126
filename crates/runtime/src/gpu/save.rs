//! The lists of a cloth's state on the device: copied out and in, in the order of the encoder.

use bytemuck::cast_slice;
use wgpu::{Buffer, BufferUsages};

use super::arena::Arena;
use super::span::Span;
use super::upload::filled;
use super::{Gpu, begin};
use crate::passes::{Pass, has_levels};
use crate::shaders::{Slot, source};
use crate::state::{Layout, Part};
use crate::world::World;

impl Gpu {
    /// Where a list lies.
    pub(super) fn part(&self, cloth: usize, part: Part) -> Option<&Span> {
        let of = &self.cloths[cloth];
        match part {
            Part::Now => Some(&of.now),
            Part::Before => Some(&of.before),
            Part::Good => of.others.get(&Slot::Good),
            Part::Lost => of.others.get(&Slot::Lost),
            Part::Holes => of.holes.as_ref(),
            Part::Rest => of.others.get(&Slot::Rest),
            Part::Tethers => of.others.get(&Slot::Tethers),
        }
    }

    /// The lists that a layout has, where each lies, and where it lies in a copy \[bytes\].
    fn parts(&self, cloth: usize, layout: &Layout) -> impl Iterator<Item = (&Span, u64, u64)> {
        let lists = Part::ALL.iter().map(|part| (*part, layout.range(*part))).filter(|(_, range)| !range.is_empty());
        let place = move |(part, range): (Part, std::ops::Range<usize>)| {
            Some((self.part(cloth, part)?, 4 * range.start as u64, 4 * range.len() as u64))
        };
        lists.collect::<Vec<_>>().into_iter().filter_map(place)
    }

    /// Records copies of the lists into a buffer.
    pub fn save(
        &mut self,
        encoder: &mut wgpu::CommandEncoder,
        cloth: usize,
        layout: &Layout,
        (buffer, offset): (&Buffer, u64),
    ) {
        for (span, at, size) in self.parts(cloth, layout) {
            encoder.copy_buffer_to_buffer(&span.buffer, span.offset, buffer, offset + at, size);
        }
        // Cloth goes on from here as from the state.
        self.forget_surface(cloth);
    }

    /// Records copies of the lists from a buffer, and rebuilds what follows from them.
    pub fn load(
        &mut self,
        world: &World,
        encoder: &mut wgpu::CommandEncoder,
        cloth: usize,
        layout: &Layout,
        (buffer, offset): (&Buffer, u64),
    ) {
        for (span, at, size) in self.parts(cloth, layout) {
            encoder.copy_buffer_to_buffer(buffer, offset + at, &span.buffer, span.offset, size);
        }
        self.forget_surface(cloth);
        let (of, run) = (&world.scene.cloths[cloth], &world.runs[cloth]);
        self.cloths[cloth].stale = true;
        let levels = layout.rest && has_levels(of, &world.control.options);
        // No frame makes the normals of cloth that is asleep.
        let drawn = |p: &&Pass| run.asleep && matches!(p, Pass::Normals { .. } | Pass::SeamNormals);
        let passes: Vec<Pass> = levels
            .then_some(Pass::CutLevels)
            .into_iter()
            .chain(run.schedule.frame.iter().filter(drawn).copied())
            .collect();
        self.mirror(world, encoder);
        if !passes.is_empty() {
            let mut pass = begin(encoder, "state");
            for what in passes {
                let groups = source(&what.into()).workgroups(of);
                self.once(world, &mut pass, cloth, what, &[], groups);
            }
        }
    }

    /// The same from the host's memory.
    pub(super) fn load_words(
        &mut self,
        world: &World,
        encoder: &mut wgpu::CommandEncoder,
        cloth: usize,
        (layout, words): (&Layout, &[u32]),
    ) {
        let buffer = self.upload_once(cast_slice(words));
        self.load(world, encoder, cloth, layout, (&buffer, 0));
    }

    /// Makes the buffers that cuts change again, as before any cut; with room for cuts if the cloth is cut, as a state is to follow.
    pub fn renew(&mut self, world: &World, cloth: usize) {
        let (of, run) = (&world.scene.cloths[cloth], &world.runs[cloth]);
        let buffers = &mut self.cloths[cloth];
        buffers.mend();
        if of.is_cut() {
            buffers.open(&self.device, of, &run.tethers, &world.control.options);
        }
        // The lists that whole frames read may still be those of the cut.
        buffers.stale = true;
        buffers.separate(&self.device, world, cloth);
        self.arenas.iter_mut().for_each(Arena::renew);
        self.open_arenas(world);
    }

    /// Where the vectors of a cloth lie that calls of a host change: among its own buffers, and in the lists of its arena.
    pub(super) fn vectors(&self, world: &World, cloth: usize, slot: Slot) -> Vec<Span> {
        let own = self.cloths[cloth].others.get(&slot).cloned();
        let mut arenas = world.arenas.iter().zip(&self.arenas);
        let member = |list: &[usize]| list.iter().position(|c| *c == cloth);
        let shared = arenas.find_map(|(list, arena)| arena.vectors(member(&list.cloths)?, slot));
        own.into_iter().chain(shared).collect()
    }

    /// Records that the targets of a cloth's limits, and the spheres of its backstops, follow its start.
    pub(super) fn aim(&mut self, world: &World, encoder: &mut wgpu::CommandEncoder, cloth: usize) {
        let (run, of) = (&world.runs[cloth], &world.scene.cloths[cloth]);
        let lists = [(Slot::Targets, run.targets(of)), (Slot::Backs, run.spheres(of))];
        for (slot, list) in lists.iter().filter(|(_, list)| !list.is_empty()) {
            let buffer = self.upload_once(cast_slice(list));
            for span in self.vectors(world, cloth, *slot) {
                encoder.copy_buffer_to_buffer(&buffer, 0, &span.buffer, span.offset, 16 * list.len() as u64);
            }
        }
    }

    /// A buffer to be copied from.
    fn upload_once(&self, contents: &[u8]) -> Buffer {
        filled(&self.device, "state", contents, BufferUsages::COPY_SRC)
    }
}
