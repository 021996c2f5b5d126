//! Which cloths share a dispatch.

use std::sync::{Arc, OnceLock};

use super::World;
use super::dispatch::{by_loops, by_work};
use crate::form::Fused;
use crate::fused::{HEADS, room_of};
use crate::passes::Schedule;
use crate::shaders::listed;

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
    /// Most steps in one dispatch.
    pub most: u32,
    /// Places in the arena's list of cloths.
    pub members: Vec<usize>,
}

impl Batch {
    /// Its dispatches in a frame of `steps` steps. A frame without a step has one: it makes normals.
    pub fn parts(&self, steps: u32) -> u32 {
        steps.div_ceil(self.most.max(1)).max(1)
    }
}

impl World {
    /// Which cloths run fused; to be called when schedules have changed.
    pub fn fuse(&mut self) {
        self.runs.iter_mut().for_each(|run| (run.fused, run.order) = (None, OnceLock::new()));
        let Some(room) = self.room.filter(|_| self.control.options.fused) else { return };
        let (iterations, relaxations) = (self.control.options.iterations, self.control.options.relaxations());
        // Cloths whose frames are alike share them, so that a batch is found by comparing addresses.
        let mut frames: Vec<(Arc<Schedule>, bool)> = Vec::new();
        let opens: Vec<bool> = (0..self.arenas.len()).map(|arena| self.opens(arena)).collect();
        let members = self.arenas.iter().zip(opens).flat_map(|(cloths, opens)| cloths.iter().map(move |c| (c, opens)));
        for (index, opens) in members {
            let solids = self.solid_loops(*index);
            let (cloth, run) = (&self.scene.cloths[*index], &mut self.runs[*index]);
            if cloth.is_cut() && !opens {
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
            let fused = fits.then(|| Fused::of(cloth, frame, &room));
            run.most = fused.as_ref().map_or(0, |f| by_loops((cloth, solids), f, iterations, &room));
            run.fused = fused.filter(|f| run.most > 0 && by_work(relaxations, f.places, 1, &room) > 0);
        }
    }

    /// Whether the shared lists of an arena fit a buffer with those that cuts change.
    pub fn opens(&self, arena: usize) -> bool {
        let bytes = |index: &usize| {
            let (cloth, slots) = (&self.scene.cloths[*index], self.runs[*index].tethers.per_particle);
            listed(cloth, slots, room_of(cloth.len())) as u64
        };
        let lists = HEADS + self.arenas[arena].iter().map(bytes).sum::<u64>();
        self.room.is_some_and(|room| lists <= room.bytes)
    }

    /// Whether a cloth runs fused.
    pub fn is_fused(&self, cloth: usize) -> bool {
        self.runs.get(cloth).is_some_and(|run| run.fused.is_some())
    }

    /// Whether the passes of a cloth that is awake have dispatches of their own.
    pub fn is_apart(&self, cloth: usize) -> bool {
        !self.runs[cloth].asleep && !self.is_fused(cloth)
    }

    /// The batches of a frame, of the cloths that are awake.
    pub fn batches(&self) -> Vec<Batch> {
        let mut batches = Vec::new();
        self.batch(&mut batches);
        batches
    }

    /// The same in place of those of another frame, whose memory is used again.
    pub fn batch(&self, batches: &mut Vec<Batch>) {
        let mut count = 0;
        for (arena, cloths) in self.arenas.iter().enumerate() {
            let first = count;
            for (member, cloth) in cloths.iter().enumerate() {
                let run = &self.runs[*cloth];
                let Some(fused) = run.fused.as_ref().filter(|_| !run.asleep) else {
                    continue;
                };
                let solids = self.solid_count(*cloth);
                let fits =
                    |b: &&mut Batch| b.solids == solids && b.fused.kind() == fused.kind() && b.members.len() < MOST;
                match batches[first..count].iter_mut().find(fits) {
                    Some(batch) => {
                        batch.fused = batch.fused.with(fused);
                        batch.most = batch.most.min(run.most);
                        batch.members.push(member);
                    }
                    None => {
                        let mut members = batches.get_mut(count).map_or(Vec::new(), |b| std::mem::take(&mut b.members));
                        members.clear();
                        members.push(member);
                        let batch = Batch { arena, fused: fused.clone(), solids, most: run.most, members };
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
        let relaxations = self.control.options.relaxations();
        for batch in batches {
            let room = self.room.as_ref();
            let most = room.map(|room| by_work(relaxations, batch.fused.places, batch.members.len(), room));
            batch.most = batch.most.min(most.unwrap_or(u32::MAX));
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::cloth::{Cloth, Flat};
    use crate::fused::Room;
    use crate::options::Options;
    use crate::scene::Scene;
    use crate::tuning::Tuning;

    #[test]
    fn cut_cloth_runs_apart_if_the_shared_lists_would_be_too_long() {
        let mut sheet = Flat::square("sheet", 16).cloth().unwrap();
        [0, 15].into_iter().for_each(|k| sheet.set_pinned(k, true).unwrap());
        let mut scene = Scene::new("two");
        scene.cloths = vec![sheet.clone(), sheet];
        // Two vectors of state per particle; lists of cut cloth take 36 bytes.
        let uncut = HEADS + 2 * 32 * 256;
        for (bytes, fused) in [(uncut, false), (2 * uncut, true)] {
            let mut world = World::new(scene.clone(), Options::default()).unwrap();
            let (memory, loops, tuning) = (65_536, u32::MAX, Tuning::NONE);
            world.make_room(Room { memory, threads: 64, buffers: 8, loops, busy: 8, bytes, tuning });
            assert_eq!((world.arenas.len(), world.is_fused(0)), (1, true), "{bytes}");
            world.scene.cloths.iter_mut().for_each(Cloth::open);
            world.reschedule();
            assert_eq!([world.is_fused(0), world.is_fused(1)], [fused; 2], "{bytes}");
        }
    }
}
