//! The dispatches by which tethers follow a cut on the GPU.

use bytemuck::cast_slice;
use wgpu::{Buffer, BufferUsages};

use super::Gpu;
use super::span::Span;
use super::upload::{filled, upload};
use crate::cloth::{Bridges, Cloth, Rest, Tethers, groups, mates};
use crate::cpu::route::UNSUPPORTED;
use crate::passes::Pass;
use crate::shaders::Slot;
use crate::world::World;

/// Buffers that rounds read and write beside rest lengths and tethers.
pub(super) fn room(device: &wgpu::Device, cloth: &Cloth, tethers: &Tethers) -> Vec<(Slot, Buffer)> {
    if !follows(cloth, tethers) {
        return Vec::new();
    }
    let none = BufferUsages::empty();
    let supports: Vec<_> = groups(cloth, tethers).into_iter().map(|group| [group, UNSUPPORTED]).collect();
    let mut room = vec![
        (Slot::Supports, upload(device, "supports", &supports, none)),
        (Slot::Holding, upload(device, "holding", &vec![[0u32; 2]; supports.len()], none)),
        (Slot::Changes, upload(device, "changes", &vec![0u32; 4 + 3 * cloth.len()], none)),
    ];
    let [seams, sewn] = joins(cloth);
    if seams {
        let mut links = mates(cloth);
        if sewn {
            links.extend(bridge_words(cloth));
        }
        room.push((Slot::Mates, upload(device, "mates", &links, none)));
    }
    room
}

/// Whether the passes read links of seams, and stitches behind them.
fn joins(cloth: &Cloth) -> [bool; 2] {
    let sewn = !cloth.stitches().is_empty();
    [sewn || cloth.ring_count() > 0, sewn]
}

/// Stitches as shaders/part/bridges.wgsl reads them: where those of each texel begin, then three words for each end.
fn bridge_words(cloth: &Cloth) -> Vec<u32> {
    let mut bridges = Bridges::of(cloth);
    if bridges.starts.is_empty() {
        bridges.starts = vec![0; cloth.len() + 1];
    }
    let ends = bridges.ends.iter().flat_map(|(k, length, quad)| [*k, length.to_bits(), *quad]);
    bridges.starts.iter().copied().chain(ends).collect()
}

/// Whether a cloth has tethers that a cut can reach.
fn follows(cloth: &Cloth, tethers: &Tethers) -> bool {
    tethers.per_particle > 0 && !matches!(cloth.rest(), Rest::None)
}

/// The passes that update the tethers of a cloth after a cut: for all texels, and in a walk.
pub(super) fn cut_tethers(cloth: &Cloth, tethers: &Tethers) -> Option<[Pass; 2]> {
    let (slots, [seams, sewn]) = (tethers.per_particle as u32, joins(cloth));
    follows(cloth, tethers).then_some([false, true].map(|walks| Pass::CutTethers { slots, seams, sewn, walks }))
}

/// Threads of the workgroup that walks.
const GROUP: u64 = 256;
/// Most dispatches that walk in a phase.
const MAX_WALKS: u64 = 64;
/// Most texels per thread in one of them.
const MAX_TEXELS: u64 = 1 << 20;

/// The limits of the walk through the texels beside changes, in each of the two phases.
#[derive(Clone, Copy, Debug, PartialEq)]
struct Walk {
    /// Rounds of a phase. A way that a cut has changed leads by at most that many particles, or its tether ends: twice along the longer
    /// side, of two grids if there are several, and of all if stitches tie them.
    rounds: u64,
    /// Texels per thread and dispatch.
    texels: u64,
    /// Dispatches: one, or more on a device that ends loops early.
    dispatches: u64,
}

impl Walk {
    /// Limits for a device on which a thread makes at most `loops` iterations of loops per dispatch.
    fn new(cloth: &Cloth, tethers: &Tethers, loops: u32) -> Self {
        let (longest, grids) = (cloth.grids().iter().map(|g| g.width.max(g.height)).max(), cloth.grids().len() as u64);
        let longest = u64::from(longest.unwrap_or(0));
        let (slots, (starts, _)) = (tethers.per_particle as u64, cloth.rings());
        let ring = u64::from(starts.windows(2).map(|ends| ends[1] - ends[0]).max().unwrap_or(1));
        // Iterations for a texel: what is around each duplicate, for each slot, and the texels beside it that go into a list.
        let over = if cloth.stitches().is_empty() { 0 } else { u64::from(Bridges::of(cloth).most()) };
        let texel = slots * (2 + ring * ((8 + over) * (2 + slots + grids) + 20)) + (8 + over) * (1 + ring) + 4;
        // The loop that ends all tethers.
        let ends = (slots * cloth.len() as u64).div_ceil(GROUP);
        let rounds = 2 * longest * if cloth.stitches().is_empty() { grids.min(2) } else { grids };
        let texels = (u64::from(loops).saturating_sub(ends + rounds) / texel).clamp(1, MAX_TEXELS);
        // The front of changes is about as long as both sides of a cut, with the texels beside them; twice that for fronts that cross.
        let need = 2 * rounds * (4 * longest).div_ceil(GROUP);
        Walk { rounds, texels, dispatches: need.div_ceil(texels).clamp(1, MAX_WALKS) }
    }

    /// The dispatches after a cut, in order: whether one walks, and its numbers.
    fn dispatches(&self) -> Vec<(bool, [f32; 4])> {
        let mut all = Vec::new();
        for phase in [1, 2] {
            all.extend([2 * phase - 1, 2 * phase].map(|stage| (false, [stage as f32, 0.0, 0.0, 0.0])));
            let walk = |n| {
                [phase as f32, self.rounds as f32, self.texels as f32, f32::from(u8::from(n + 1 == self.dispatches))]
            };
            all.extend((0..self.dispatches).map(|n| (true, walk(n))));
        }
        all
    }
}

impl Gpu {
    /// Records the search for what supports tethers, before a cut.
    pub(super) fn before_cut(&mut self, world: &World, pass: &mut wgpu::ComputePass, cloth: usize) {
        self.follow_cut(world, pass, cloth, &[(false, [0.0; 4])]);
    }

    /// Records the change of tethers after a cut.
    pub(super) fn after_cut(&mut self, world: &World, pass: &mut wgpu::ComputePass, cloth: usize) {
        let loops = world.room.as_ref().map_or(u32::MAX, |room| room.loops);
        let walk = Walk::new(&world.scene.cloths[cloth], &world.runs[cloth].tethers, loops);
        self.follow_cut(world, pass, cloth, &walk.dispatches());
    }

    fn follow_cut(
        &mut self,
        world: &World,
        pass: &mut wgpu::ComputePass,
        index: usize,
        dispatches: &[(bool, [f32; 4])],
    ) {
        let (cloth, tethers) = (&world.scene.cloths[index], &world.runs[index].tethers);
        let Some(passes) = cut_tethers(cloth, tethers) else { return };
        self.cloths[index].separate(&self.device, world, index);
        // Where a binding may begin.
        let mut rows = vec![[0.0f32; 4]; 16 * dispatches.len()];
        dispatches.iter().enumerate().for_each(|(n, (_, numbers))| rows[16 * n] = *numbers);
        let rows = filled(&self.device, "stages", cast_slice(&rows), BufferUsages::STORAGE);
        for (n, (walks, _)) in dispatches.iter().enumerate() {
            let pipeline = self.pipelines.get(&passes[usize::from(*walks)].into());
            let numbers = Span { buffer: rows.clone(), offset: 256 * n as u64, size: 16 };
            let group = self.cloths[index].bind(&self.device, pipeline, &[(Slot::Action, &numbers)]);
            let [x, y, z] = pipeline.source.workgroups(cloth);
            pass.set_pipeline(&pipeline.pipeline);
            pass.set_bind_group(0, &group, &[]);
            pass.dispatch_workgroups(x, y, z);
        }
    }
}

#[cfg(test)]
#[path = "cut_tethers_tests.rs"]
mod tests;
