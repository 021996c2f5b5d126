//! How many steps of whole frames one dispatch makes.

use crate::cloth::Cloth;
use crate::form::Fused;
use crate::fused::Room;
use crate::loops;

/// Relaxations of a workgroup in one dispatch, each particle's of a round being one: a device may take a dispatch that does not end for
/// lost. 512 rounds of 64 x 64 particles.
const MAX_WORK: u64 = 1 << 21;

/// Most steps of whole frames with a number of relaxations per step in one dispatch of `cloths` cloths that have `places` particles at
/// most; 0 where even one step is too much for a single cloth.
pub(super) fn by_work(relaxations: u32, places: u32, cloths: usize, room: &Room) -> u32 {
    // A device that is busy with some takes longer for more.
    let after = (cloths as u64).div_ceil(u64::from(room.busy.max(1))).max(1);
    let one = MAX_WORK / (u64::from(relaxations) * u64::from(places)).max(1);
    (one / after).max(one.min(1)) as u32
}

/// The same by the iterations of a thread's loops, of a cloth and [`loops::of_solids`] of its colliders.
pub(super) fn by_loops(among: (&Cloth, u64), fused: &Fused, iterations: u32, room: &Room) -> u32 {
    let [step, beside] = loops::of_whole(fused, among, iterations);
    (u64::from(room.loops).saturating_sub(beside) / step).min(u64::from(u32::MAX)) as u32
}

/// Particles in one dispatch of a step that makes a number of relaxations: as many as all workgroups that a device runs at a time may make of whole
/// frames.
pub(super) fn most_at_once(relaxations: u32, room: &Room) -> u64 {
    MAX_WORK * u64::from(room.busy.max(1)) / u64::from(relaxations.max(1))
}

#[cfg(test)]
mod tests {
    use std::sync::Arc;

    use super::*;
    use crate::cloth::Flat;
    use crate::options::Options;
    use crate::scene::Scene;
    use crate::tuning::Tuning;
    use crate::world::World;

    const ROOM: Room = Room {
        memory: 65_536,
        threads: 64,
        buffers: 8,
        loops: u32::MAX,
        busy: 8,
        bytes: 1 << 27,
        whole: u32::MAX,
        cloths: 1,
        tuning: Tuning::NONE,
    };

    fn most(n: u32, options: Options, room: Room) -> u32 {
        let mut scene = Scene::new("one");
        scene.cloths.push(Flat::square("sheet", n).cloth().unwrap());
        let world = World::new(scene, options).unwrap();
        let cloth = &world.scene.cloths[0];
        let fused = Fused::of(cloth, &Arc::new(world.runs[0].schedule.clone()), &room).unwrap();
        let options = &world.control.options;
        by_work(options.relaxations(), fused.places, 1, &room).min(by_loops(
            (cloth, 0),
            &fused,
            options.iterations,
            &room,
        ))
    }

    #[test]
    fn a_dispatch_is_bounded_by_work_and_by_loops() {
        let rounds = |iterations| Options { substeps: Some(8), iterations, ..Options::default() };
        assert_eq!([1, 2, 512, 4096].map(|n| most(64, rounds(n), ROOM)), [512, 256, 1, 0]);
        assert_eq!(most(32, rounds(1), ROOM), 2048, "the smaller, the more steps");
        let few = Room { loops: 65_535, ..ROOM };
        let steps = most(64, rounds(1), few);
        // Four colours, the integration, contact and what is beside them: some nine passes with 64 particles per thread.
        assert!((65_535 / 64 / 14..65_535 / 64 / 7).contains(&steps), "{steps}");
        assert!(most(64, rounds(4), few) < steps / 2);
    }

    #[test]
    fn a_dispatch_of_more_cloths_than_keep_a_device_busy_has_fewer_steps() {
        let steps = |cloths| by_work(9, 4096, cloths, &ROOM);
        assert_eq!([1, 8, 9, 80, 65_535].map(steps), [56, 56, 28, 5, 1]);
        assert_eq!(by_work(1024, 4096, 1, &ROOM), 0, "a step that is too much");
    }
}
