//! How many steps of whole frames one dispatch makes.

use crate::choose::Settings;
use crate::cloth::Cloth;
use crate::form::Fused;
use crate::fused::Room;
use crate::passes::{Air, Kinds, Pass};
use crate::shaders::{Over, over};

/// Relaxations of a workgroup in one dispatch, each particle's of a round being one: a device may take a dispatch that does not end for
/// lost. 512 rounds of 64 x 64 particles.
const MAX_WORK: u64 = 1 << 21;

/// Most steps of the whole frames of a cloth among a number of colliders in one dispatch; 0 where even one step is too much.
pub(super) fn most_steps(cloth: &Cloth, solids: usize, fused: &Fused, options: &Settings, room: &Room) -> u32 {
    let by_work = MAX_WORK / (u64::from(options.relaxations()) * u64::from(fused.places)).max(1);
    let schedule = &fused.schedule;
    let loops = |list: &[Pass]| list.iter().map(|pass| loops(pass, cloth, solids, fused)).sum::<u64>();
    let once = loops(&schedule.frame) + 4 * each(fused);
    let step = loops(&schedule.air) + loops(&schedule.step) + u64::from(options.iterations) * loops(&schedule.relax);
    let by_loops = u64::from(room.loops).saturating_sub(once) / step.max(1);
    by_work.min(by_loops).min(u64::from(u32::MAX)) as u32
}

/// Iterations of a thread over all particles.
fn each(fused: &Fused) -> u64 {
    u64::from(fused.places.div_ceil(fused.threads.max(1)))
}

/// Iterations of the loops that noise and the nearest point of an ellipsoid take.
const GUST: usize = 16;
const NEAREST: usize = 80;

/// Iterations of a thread in a pass, at most.
fn loops(pass: &Pass, cloth: &Cloth, solids: usize, fused: &Fused) -> u64 {
    let near = |kinds: &Kinds| solids * if kinds.shapes[5] { NEAREST } else { 4 };
    let within = match pass {
        Pass::Contact(kinds) => 2 + near(kinds),
        Pass::Tethers { slots } => 1 + *slots as usize,
        Pass::Wind { .. } => 4 * (1 + GUST),
        Pass::Integrate(Air::Push) | Pass::IntegrateExact(Air::Push) => 1 + GUST,
        _ => match over(*pass) {
            // Duplicates are gone through twice.
            Over::Rings => return rings(cloth, fused),
            Over::Texels => 12,
            _ => 1,
        },
    };
    each(fused) * within as u64 + 2 * cloth.grids().len() as u64 + 1
}

/// The same of a pass over seam rings.
fn rings(cloth: &Cloth, fused: &Fused) -> u64 {
    let (starts, _) = cloth.rings();
    let longest = starts.windows(2).map(|ends| ends[1] - ends[0]).max().unwrap_or(0);
    u64::from((cloth.ring_count() as u32).div_ceil(fused.threads.max(1))) * u64::from(1 + 2 * longest) + 1
}

#[cfg(test)]
mod tests {
    use std::sync::Arc;

    use super::*;
    use crate::cloth::Flat;
    use crate::options::Options;
    use crate::scene::Scene;
    use crate::world::World;

    const ROOM: Room = Room { memory: 65_536, threads: 64, buffers: 8, loops: u32::MAX, busy: 8, bytes: 1 << 27 };

    fn most(n: u32, options: Options, room: Room) -> u32 {
        let mut scene = Scene::new("one");
        scene.cloths.push(Flat::square("sheet", n).cloth().unwrap());
        let world = World::new(scene, options).unwrap();
        let cloth = &world.scene.cloths[0];
        let fused = Fused::of(cloth, &Arc::new(world.runs[0].schedule.clone()), &room);
        most_steps(cloth, 0, &fused, &world.control.options, &room)
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
}
