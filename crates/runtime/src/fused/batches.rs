//! Which cloths lie in the same buffers, and which of them share a dispatch.

use std::sync::Arc;

use super::{Fused, Hold, Room};
use crate::cloth::{Cloth, Rest};
use crate::options::{Options, Solver};
use crate::passes::{Schedule, soft_of};
use crate::world::World;

/// From this number of cloths on, those that are too large for the memory of a workgroup run a workgroup each; fewer would leave most of a
/// device idle.
const MANY: usize = 16;
/// Relaxations of a frame: longer ones run in separate passes, as a device may take a dispatch that does not end for lost.
const LONGEST: u32 = 512;
/// Workgroups of a dispatch in a row.
const MOST: usize = 65_535;

/// Cloths that lie in the same buffers, by index; in order.
pub fn arenas(cloths: &[Cloth], slots: impl Fn(usize) -> usize, options: &Options, room: &Room) -> Vec<Vec<usize>> {
    let mut arenas: Vec<(_, u64, Vec<usize>)> = Vec::new();
    let small = |c: &Cloth| room.hold(c.len(), 0) != Hold::Stored;
    let large = cloths.iter().filter(|c| !small(c)).count();
    for (index, cloth) in cloths.iter().enumerate() {
        if options.solver != Solver::Xpbd || !options.fused || (!small(cloth) && large < MANY) {
            continue;
        }
        let (image, rings) = (matches!(cloth.rest(), Rest::Image(_)), cloth.ring_count() > 0);
        let soft = soft_of(cloth);
        let fabric = (cloth.is_exact(), cloth.bending().is_some(), cloth.membrane().is_some());
        let kind = (image, rings, soft, slots(index), fabric);
        // No other buffer has more bytes per particle.
        let wide = if cloth.membrane().is_some() { 4 } else { 2 };
        let bytes = room_of(cloth.len()) as u64 * 8 * (slots(index) as u64).max(wide);
        let fits = |a: &&mut (_, u64, Vec<usize>)| a.0 == kind && a.1 + bytes <= room.bytes;
        match arenas.iter_mut().find(fits) {
            Some(arena) => {
                arena.1 += bytes;
                arena.2.push(index);
            }
            None => arenas.push((kind, bytes, vec![index])),
        }
    }
    arenas.into_iter().map(|a| a.2).collect()
}

/// Entries that a cloth takes up in the buffers of an arena: each begins where a binding may begin.
pub const fn room_of(particles: usize) -> usize {
    particles.next_multiple_of(64)
}

/// Cloths that share a dispatch.
#[derive(Clone, Debug, PartialEq)]
pub struct Batch {
    /// Index of the arena.
    pub arena: usize,
    /// What runs.
    pub fused: Fused,
    /// Places in the arena's list of cloths.
    pub members: Vec<usize>,
}

impl World {
    /// Which cloths run fused; to be called when schedules have changed.
    pub fn fuse(&mut self) {
        self.fused = vec![None; self.schedules.len()];
        self.orders = vec![Default::default(); self.schedules.len()];
        let Some(room) = self.room.filter(|_| self.options.fused) else { return };
        // Cloths whose frames are alike share them, so that a batch is found by comparing addresses.
        let mut frames: Vec<(Arc<Schedule>, bool)> = Vec::new();
        for index in self.arenas.iter().flatten() {
            let (cloth, schedule) = (&self.scene.cloths[*index], &self.schedules[*index]);
            // Rest lengths and tethers that a cut has changed are the cloth's own.
            if cloth.is_cut() {
                continue;
            }
            let known = frames.iter().position(|(frame, _)| **frame == *schedule);
            let at = known.unwrap_or_else(|| {
                let frame = Arc::new(schedule.clone());
                let fits = Fused::buffers(&frame).is_some_and(|count| count <= room.buffers as usize);
                frames.push((frame, fits));
                frames.len() - 1
            });
            let (frame, fits) = &frames[at];
            self.fused[*index] = fits.then(|| Fused::of(cloth, frame, &room));
        }
    }

    /// Whether a cloth runs fused in a frame of `steps` steps.
    pub fn is_fused(&self, cloth: usize, steps: u32) -> bool {
        let (iterations, polish) = (self.options.iterations, self.options.polish);
        let short = steps.saturating_mul(iterations).saturating_mul(polish + 1) <= LONGEST;
        short && self.fused.get(cloth).is_some_and(Option::is_some)
    }

    /// The dispatches of a frame of `steps` steps, for the cloths that are awake.
    pub fn batches(&self, steps: u32) -> Vec<Batch> {
        let mut batches: Vec<Batch> = Vec::new();
        for (arena, cloths) in self.arenas.iter().enumerate() {
            let first = batches.len();
            for (member, cloth) in cloths.iter().enumerate() {
                if self.asleep[*cloth] || !self.is_fused(*cloth, steps) {
                    continue;
                }
                let Some(fused) = &self.fused[*cloth] else { continue };
                let fits = |b: &&mut Batch| b.fused.kind() == fused.kind() && b.members.len() < MOST;
                match batches[first..].iter_mut().find(fits) {
                    Some(batch) => {
                        batch.fused = batch.fused.with(fused);
                        batch.members.push(member);
                    }
                    None => batches.push(Batch { arena, fused: fused.clone(), members: vec![member] }),
                }
            }
        }
        batches
    }
}
