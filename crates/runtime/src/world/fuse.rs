//! Which cloths share a dispatch.

use std::sync::{Arc, OnceLock};

use super::World;
use super::dispatch::{by_loops, by_work, most_at_once};
use crate::choose::Settings;
use crate::form::Fused;
use crate::fused::{HEADS, Room, room_of};
use crate::passes::{Schedule, has_levels};
use crate::shaders::{Extent, is_shared, listed};
use crate::tile::{Among, Sequence, sequence};
use crate::{levels, loops};

/// Workgroups of a dispatch along one axis.
const MAX_WORKGROUPS: usize = 65_535;

/// Particles that the workgroups of a dispatch have room for, at most, for each particle of its cloths. Every grid has as many workgroups as the
/// largest grid, and empty workgroups cost time too.
const MAX_ROOM: u64 = 8;

/// Cloths that share dispatches.
#[derive(Clone, Debug, PartialEq)]
pub struct Batch {
    /// Index of the arena.
    pub arena: usize,
    /// The work that runs.
    pub share: Share,
    /// Places in the arena's list of cloths.
    pub members: Vec<usize>,
}

/// Work of cloths in the dispatches that they share.
#[derive(Clone, Debug, PartialEq)]
pub enum Share {
    /// Whole frames, a workgroup a cloth.
    Whole {
        fused: Fused,
        /// Colliders that each cloth meets.
        solids: usize,
        /// Most steps in one dispatch.
        most: u32,
    },
    /// Step by step, in tiles and passes of their own.
    Steps {
        sequence: Arc<Sequence>,
        /// The largest of the cloths.
        extent: Extent,
        /// Forces of air act on some cloth in every step that is a multiple of it.
        hold: u32,
        /// Those of all cloths.
        particles: u64,
    },
}

impl Batch {
    /// Its dispatches in a frame of `steps` steps where these are whole frames. A frame without a step has one: it makes normals.
    pub fn parts(&self, steps: u32) -> u32 {
        let most = if let Share::Whole { most, .. } = &self.share { *most } else { 1 };
        steps.div_ceil(most.max(1)).max(1)
    }

    /// Takes in one more cloth if it can share the dispatches; `most` is the number of particles in a dispatch.
    fn take(&mut self, member: usize, other: &Share, most: u64) -> bool {
        let next = self.members.len() + 1;
        let joined = match (&mut self.share, other) {
            (Share::Whole { fused, solids, most }, Share::Whole { fused: of, solids: met, most: one }) => {
                let fits = *solids == *met && fused.kind() == of.kind() && next <= MAX_WORKGROUPS;
                if fits {
                    *fused = fused.with(of);
                    *most = (*most).min(*one);
                }
                fits
            }
            (
                Share::Steps { sequence, extent, hold, particles },
                Share::Steps { sequence: of, extent: size, hold: time, particles: more },
            ) => {
                let (both, all) = (extent.with(*size), *particles + more);
                let layers = next as u64 * u64::from(both.grids);
                let fits = Arc::ptr_eq(sequence, of) && all <= most && layers <= MAX_WORKGROUPS as u64;
                let fits = fits && layers * u64::from(both.sides[0]) * u64::from(both.sides[1]) <= MAX_ROOM * all;
                if fits {
                    (*extent, *hold, *particles) = (both, common(*hold, *time), all);
                }
                fits
            }
            _ => false,
        };
        if joined {
            self.members.push(member);
        }
        joined
    }
}

/// Relaxations of a step of whole frames, coarser grids included: they have a third of the particles, and some for their borders.
fn work_of_step(options: &Settings, fused: &Fused) -> u32 {
    options.relaxations().saturating_add(u32::from(!fused.schedule.coarse.is_empty()))
}

/// The greatest common divisor.
fn common(a: u32, b: u32) -> u32 {
    if b == 0 { a } else { common(b, a % b) }
}

/// Sequences by the number of a schedule, what their loops depend on, and an arena with the grids that they are made for.
type Known = Vec<(usize, [u64; 2], usize, Arc<Sequence>)>;

impl World {
    /// Decides which cloths share dispatches; to be called when schedules have changed.
    pub fn fuse(&mut self) {
        self.runs.iter_mut().for_each(|run| (run.fused, run.sequence, run.order) = (None, None, OnceLock::new()));
        self.any_worn = self.runs.iter().any(|run| !run.schedule.worn.is_empty());
        self.close_places();
        let Some(room) = self.room.filter(|_| self.control.options.fused) else { return };
        let iterations = self.control.options.iterations;
        let relaxations = |fused: &Fused| work_of_step(&self.control.options, fused);
        // Cloths whose frames are alike share them, so that a batch is found by comparing addresses.
        let mut frames: Vec<(Arc<Schedule>, bool)> = Vec::new();
        let mut sequences = Known::new();
        for arena in 0..self.arenas.len() {
            let opens = self.opens(arena);
            for member in 0..self.arenas[arena].cloths.len() {
                let index = self.arenas[arena].cloths[member];
                let solids = self.solid_loops(index);
                let (cloth, run) = (&self.scene.cloths[index], &mut self.runs[index]);
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
                let tiled = cloth.len() > room.most_whole() && !cloth.is_cut() && is_shared(frame);
                if tiled {
                    let sequence = self.sequence_of((arena, index), (at, &mut sequences), &room);
                    if sequence.is_short() {
                        self.runs[index].sequence = Some(sequence);
                        continue;
                    }
                }
                let (cloth, run) = (&self.scene.cloths[index], &mut self.runs[index]);
                let fused = if *fits { Fused::of(cloth, frame, &room) } else { None };
                run.most = fused.as_ref().map_or(0, |f| by_loops((cloth, solids), f, iterations, &room));
                run.fused = fused.filter(|f| run.most > 0 && by_work(relaxations(f), f.places, 1, &room) > 0);
                // Only whole frames read what a cut has changed in the lists that cloths share.
                if run.fused.is_none() && !cloth.is_cut() && is_shared(&run.schedule) {
                    self.runs[index].sequence = Some(self.sequence_of((arena, index), (at, &mut sequences), &room));
                }
            }
        }
    }

    /// Whether the shared lists of an arena fit a buffer with those that cuts change.
    pub fn opens(&self, arena: usize) -> bool {
        let bytes = |index: &usize| {
            let (cloth, slots) = (&self.scene.cloths[*index], self.runs[*index].tethers.per_particle);
            let coarse = if has_levels(cloth, &self.control.options) { levels::listed(cloth) } else { [0; 2] };
            (listed(cloth, slots, room_of(cloth.len())) + coarse.iter().sum::<usize>()) as u64
        };
        let lists = HEADS + self.arenas[arena].cloths.iter().map(bytes).sum::<u64>();
        self.room.is_some_and(|room| lists <= room.bytes)
    }

    /// The dispatches of a cloth of an arena, whose schedule has a number. Cloths with the same share them.
    fn sequence_of(
        &self,
        (arena, index): (usize, usize),
        (schedule, known): (usize, &mut Known),
        room: &Room,
    ) -> Arc<Sequence> {
        let cloth = &self.scene.cloths[index];
        // Sizes depend on these only where loops are bounded.
        let bounded = |count: u64| if room.loops == u32::MAX { 0 } else { count };
        let [solids, ring] = [bounded(self.solid_loops(index)), bounded(loops::of_ring(cloth))];
        let sides = &self.arenas[arena].sides;
        let same = |k: &&(usize, [u64; 2], usize, _)| {
            (k.0, k.1) == (schedule, [solids, ring]) && self.arenas[k.2].sides == *sides
        };
        if let Some((.., sequence)) = known.iter().find(same) {
            return sequence.clone();
        }
        let among = Among { sides, solids, ring, shared: true, rounds: self.control.options.iterations };
        let sequence = Arc::new(sequence(&among, &self.runs[index].schedule, room));
        known.push((schedule, [solids, ring], arena, sequence.clone()));
        sequence
    }

    /// Whether a cloth runs whole frames.
    pub fn is_fused(&self, cloth: usize) -> bool {
        self.runs.get(cloth).is_some_and(|run| run.fused.is_some())
    }

    /// Whether a cloth may share its dispatches with others.
    pub fn is_shared(&self, cloth: usize) -> bool {
        self.is_fused(cloth) || self.runs.get(cloth).is_some_and(|run| run.sequence.is_some())
    }

    /// Whether the passes of a cloth that is awake have dispatches of their own.
    pub fn is_apart(&self, cloth: usize) -> bool {
        !self.runs[cloth].asleep && !self.is_shared(cloth)
    }

    /// Work of a cloth in the dispatches that it shares.
    fn share(&self, index: usize) -> Option<Share> {
        let run = &self.runs[index];
        let whole =
            |fused: &Fused| Share::Whole { fused: fused.clone(), solids: self.solid_count(index), most: run.most };
        let steps = |sequence: &Arc<Sequence>| {
            let cloth = &self.scene.cloths[index];
            let particles = cloth.len() as u64;
            Share::Steps { sequence: sequence.clone(), extent: Extent::of(cloth), hold: self.hold(index), particles }
        };
        run.fused.as_ref().map(whole).or_else(|| run.sequence.as_ref().map(steps))
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
        let options = &self.control.options;
        // A dispatch makes one of a step's rounds.
        let relaxations = options.relaxations() / options.iterations.max(1);
        let most = self.room.as_ref().map_or(u64::MAX, |room| most_at_once(relaxations, room));
        for (arena, roster) in self.arenas.iter().enumerate() {
            let first = count;
            for (member, cloth) in roster.cloths.iter().enumerate().filter(|(_, c)| !self.runs[**c].asleep) {
                let Some(share) = self.share(*cloth) else { continue };
                if batches[first..count].iter_mut().any(|batch| batch.take(member, &share, most)) {
                    continue;
                }
                let mut members = batches.get_mut(count).map_or(Vec::new(), |b| std::mem::take(&mut b.members));
                members.clear();
                members.push(member);
                let batch = Batch { arena, share, members };
                if count < batches.len() {
                    batches[count] = batch;
                } else {
                    batches.push(batch);
                }
                count += 1;
            }
        }
        batches.truncate(count);
        let room = self.room.as_ref();
        for batch in batches {
            if let (Share::Whole { fused, most, .. }, Some(room)) = (&mut batch.share, room) {
                *most = (*most).min(by_work(work_of_step(options, fused), fused.places, batch.members.len(), room));
            }
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
            world.make_room(Room {
                memory,
                threads: 64,
                buffers: 8,
                loops,
                busy: 8,
                bytes,
                whole: u32::MAX,
                cloths: 1,
                tuning,
            });
            assert_eq!((world.arenas.len(), world.is_fused(0)), (1, true), "{bytes}");
            world.scene.cloths.iter_mut().for_each(Cloth::open);
            world.reschedule();
            assert_eq!([world.is_fused(0), world.is_fused(1)], [fused; 2], "{bytes}");
        }
    }
}
