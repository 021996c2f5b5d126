//! The rounds by which tethers follow a cut on the GPU.

use std::collections::HashMap;

use bytemuck::cast_slice;
use wgpu::{Buffer, BufferUsages};

use super::Gpu;
use super::span::Span;
use super::upload::{filled, upload};
use crate::cloth::{Cloth, Rest, Tethers, groups, mates};
use crate::cpu::route::UNSUPPORTED;
use crate::passes::Pass;
use crate::shaders::Slot;
use crate::world::World;

/// What rounds read and write beside rest lengths and tethers.
pub(super) fn room(device: &wgpu::Device, cloth: &Cloth, tethers: &Tethers) -> Vec<(Slot, Buffer)> {
    if !follows(cloth, tethers) {
        return Vec::new();
    }
    let none = BufferUsages::empty();
    let supports: Vec<_> = groups(cloth, tethers).into_iter().map(|group| [group, UNSUPPORTED]).collect();
    let mut room = vec![
        (Slot::Supports, upload(device, "supports", &supports, none)),
        (Slot::Holding, upload(device, "holding", &vec![[0u32; 2]; supports.len()], none)),
        (Slot::Changes, upload(device, "changes", &vec![0u32; 4 + cloth.len()], none)),
    ];
    if cloth.ring_count() > 0 {
        room.push((Slot::Mates, upload(device, "mates", &mates(cloth), none)));
    }
    room
}

/// Whether a cloth has tethers that a cut can reach.
fn follows(cloth: &Cloth, tethers: &Tethers) -> bool {
    tethers.per_particle > 0 && !matches!(cloth.rest(), Rest::None)
}

/// The pass that leads the tethers of a cloth around a cut.
pub(super) fn cut_tethers(cloth: &Cloth, tethers: &Tethers) -> Option<Pass> {
    let pass = Pass::CutTethers { slots: tethers.per_particle as u32, seams: cloth.ring_count() > 0 };
    follows(cloth, tethers).then_some(pass)
}

/// Rounds of a phase, a whole number of turns there and back. A way that a cut has changed leads by at most that many
/// particles, or its tether ends: twice along the longer side, of two grids where there are several.
fn rounds(cloth: &Cloth) -> u32 {
    let longest = cloth.grids().iter().map(|g| g.width.max(g.height)).max().unwrap_or(0);
    (2 * longest * (cloth.grids().len() as u32).min(2)).next_multiple_of(6)
}

/// Dispatches for a cut, beside those that cut.
#[derive(Clone, Copy, PartialEq, Eq, Hash)]
struct Round {
    phase: u32,
    turn: u32,
    first: bool,
    last: bool,
    /// Whether tethers lie in the other buffer.
    back: bool,
}

impl Round {
    fn number(phase: u32, n: u32, count: u32) -> Self {
        Round { phase, turn: n % 3, first: n == 0, last: n + 1 == count, back: n % 2 == 1 }
    }
}

impl Gpu {
    /// Records what is to be known of tethers before a cut.
    pub(super) fn before_cut(&mut self, world: &World, pass: &mut wgpu::ComputePass, cloth: usize) {
        self.rounds(world, pass, cloth, &[Round::number(0, 0, 1)]);
    }

    /// Records what becomes of them after it.
    pub(super) fn after_cut(&mut self, world: &World, pass: &mut wgpu::ComputePass, cloth: usize) {
        let count = rounds(&world.scene.cloths[cloth]);
        let all: Vec<_> = [1, 2].iter().flat_map(|p| (0..count).map(|n| Round::number(*p, n, count))).collect();
        self.rounds(world, pass, cloth, &all);
    }

    fn rounds(&mut self, world: &World, pass: &mut wgpu::ComputePass, index: usize, rounds: &[Round]) {
        let (cloth, tethers) = (&world.scene.cloths[index], &world.runs[index].tethers);
        let Some(what) = cut_tethers(cloth, tethers) else { return };
        self.cloths[index].separate(&self.device, world, index);
        let numbers = |r: &Round| {
            let flags = [r.phase as f32, r.turn as f32, u8::from(r.first).into(), u8::from(r.last).into()];
            filled(&self.device, "round", cast_slice(&flags), BufferUsages::STORAGE).into()
        };
        let mut each = HashMap::new();
        for round in rounds {
            each.entry(*round).or_insert_with(|| numbers(round));
        }
        let pipeline = self.pipelines.get(&what.into());
        let buffers = &self.cloths[index];
        let [Some(there), Some(back)] = [Slot::Tethers, Slot::Holding].map(|slot| buffers.others.get(&slot)) else {
            return;
        };
        let group = |(round, numbers): (&Round, &Span)| {
            let [from, to] = if round.back { [back, there] } else { [there, back] };
            let more = [(Slot::Action, numbers), (Slot::Tethers, from), (Slot::Holding, to)];
            (*round, buffers.bind(&self.device, pipeline, &more))
        };
        let groups: HashMap<_, _> = each.iter().map(group).collect();
        let [x, y, z] = pipeline.source.workgroups(cloth);
        pass.set_pipeline(&pipeline.pipeline);
        for round in rounds {
            pass.set_bind_group(0, &groups[round], &[]);
            pass.dispatch_workgroups(x, y, z);
        }
    }
}

#[cfg(test)]
#[path = "cut_tethers_tests.rs"]
mod tests;
