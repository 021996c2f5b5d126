//! Which cloths share a dispatch.

use std::sync::{Arc, OnceLock};

use super::World;
use crate::form::Fused;
use crate::passes::Schedule;

/// Relaxations of a frame: longer ones run in separate passes, as a device may take a dispatch that does not end for lost.
const LONGEST: u32 = 512;
/// Workgroups of a dispatch in a row.
const MOST: usize = 65_535;

/// Cloths that share a dispatch.
#[derive(Clone, Debug, PartialEq)]
pub struct Batch {
    /// Index of the arena.
    pub arena: usize,
    /// What runs.
    pub fused: Fused,
    /// Colliders that each of its cloths meets.
    pub solids: usize,
    /// Places in the arena's list of cloths.
    pub members: Vec<usize>,
}

impl World {
    /// Which cloths run fused; to be called when schedules have changed.
    pub fn fuse(&mut self) {
        self.runs.iter_mut().for_each(|run| (run.fused, run.order) = (None, OnceLock::new()));
        let Some(room) = self.room.filter(|_| self.control.options.fused) else { return };
        // Cloths whose frames are alike share them, so that a batch is found by comparing addresses.
        let mut frames: Vec<(Arc<Schedule>, bool)> = Vec::new();
        for index in self.arenas.iter().flatten() {
            let (cloth, run) = (&self.scene.cloths[*index], &mut self.runs[*index]);
            // Rest lengths and tethers that a cut has changed are the cloth's own.
            if cloth.is_cut() {
                continue;
            }
            let known = frames.iter().position(|(frame, _)| **frame == run.schedule);
            let at = known.unwrap_or_else(|| {
                let frame = Arc::new(run.schedule.clone());
                let fits = Fused::buffers(&frame).is_some_and(|count| count <= room.buffers as usize);
                frames.push((frame, fits));
                frames.len() - 1
            });
            let (frame, fits) = &frames[at];
            run.fused = fits.then(|| Fused::of(cloth, frame, &room));
        }
    }

    /// Whether a cloth runs fused in a frame of `steps` steps.
    pub fn is_fused(&self, cloth: usize, steps: u32) -> bool {
        let (iterations, polish) = (self.control.options.iterations, self.control.options.polish);
        let short = steps.saturating_mul(iterations).saturating_mul(polish + 1) <= LONGEST;
        short && self.runs.get(cloth).is_some_and(|run| run.fused.is_some())
    }

    /// Whether the passes of a cloth that is awake have dispatches of their own in a frame of `steps` steps.
    pub fn is_apart(&self, cloth: usize, steps: u32) -> bool {
        !self.runs[cloth].asleep && !self.is_fused(cloth, steps)
    }

    /// The dispatches of a frame of `steps` steps, for the cloths that are awake.
    pub fn batches(&self, steps: u32) -> Vec<Batch> {
        let mut batches = Vec::new();
        self.batch(steps, &mut batches);
        batches
    }

    /// The same in place of those of another frame, whose memory is used again.
    pub fn batch(&self, steps: u32, batches: &mut Vec<Batch>) {
        let mut count = 0;
        for (arena, cloths) in self.arenas.iter().enumerate() {
            let first = count;
            for (member, cloth) in cloths.iter().enumerate() {
                let run = &self.runs[*cloth];
                let Some(fused) = run.fused.as_ref().filter(|_| !run.asleep && self.is_fused(*cloth, steps)) else {
                    continue;
                };
                let solids = self.solid_count(*cloth);
                let fits =
                    |b: &&mut Batch| b.solids == solids && b.fused.kind() == fused.kind() && b.members.len() < MOST;
                match batches[first..count].iter_mut().find(fits) {
                    Some(batch) => {
                        batch.fused = batch.fused.with(fused);
                        batch.members.push(member);
                    }
                    None => {
                        let mut members = batches.get_mut(count).map_or(Vec::new(), |b| std::mem::take(&mut b.members));
                        members.clear();
                        members.push(member);
                        let batch = Batch { arena, fused: fused.clone(), solids, members };
                        if count < batches.len() {
                            batches[count] = batch;
                        } else {
                            batches.push(batch);
                        }
                        count += 1;
                    }
                }
            }
        }
        batches.truncate(count);
    }
}
