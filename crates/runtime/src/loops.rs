//! Iterations that the loops of a thread make in a dispatch, at most: some software adapters end all loops of a thread after a number of
//! them.
//!
//! Counted from the shaders: a collider that a particle meets is 8 (the search for it, its posing, the axes of a box), the nearest point of
//! an ellipsoid 24 for each of the four times that it may be asked for. Compilers make loops of what is none in a shader, so a device's
//! number has a margin ([`crate::fused::Room::of`]).

use crate::cloth::{Cloth, Grid};
use crate::collider::{Collider, Shape};
use crate::form::{Chain, Fused, Tile, TileSpan};
use crate::levels;
use crate::passes::{Air, Pass};
use crate::shaders::{Over, over, stages};

/// Iterations of noise, for a collider, and for an ellipsoid.
const GUST: u64 = 16;
const SOLID: u64 = 8;
const ELLIPSOID: u64 = 110;

/// Those of a particle for the colliders that its cloth meets.
pub fn of_solids<'a>(colliders: impl IntoIterator<Item = &'a Collider>) -> u64 {
    let one = |c: &Collider| if matches!(c.shape, Shape::Ellipsoid { closest: true, .. }) { ELLIPSOID } else { SOLID };
    colliders.into_iter().map(one).sum()
}

/// Those of a thread for all coarser grids of a cloth: each level is gathered, limited in eight colours and tied.
fn of_levels(cloth: &Cloth, threads: u32) -> u64 {
    let nodes = |grid: &Grid| levels::sizes(grid).map(|[w, h]| 9 * (each(w * h, threads) + 1)).sum::<u64>();
    let of = |grid: &Grid| nodes(grid) + 9 * u64::from(levels::most(cloth));
    let ties = u64::from(levels::most(cloth)) * (9 * each(cloth.ring_count() as u32, threads) + 9);
    cloth.grids().iter().map(of).sum::<u64>() + ties
}

/// Those of a step of a whole frame, and those beside all steps, of a cloth and [`of_solids`] of its colliders.
pub fn of_whole(fused: &Fused, (cloth, solids): (&Cloth, u64), iterations: u32) -> [u64; 2] {
    let (each, schedule) = (each(fused.places, fused.threads), &fused.schedule);
    let of = |pass: &Pass| match over(*pass) {
        Over::Rings => rings(cloth, fused.threads),
        Over::Groups(_) if matches!(pass, Pass::Pyramid { .. }) => of_levels(cloth, fused.threads),
        Over::Groups(_) => 0,
        _ => each * within(pass, solids) + 3 * cloth.grids().len() as u64 + 1,
    };
    let all = |list: &[Pass]| list.iter().map(of).sum::<u64>();
    let once = 1 + all(&schedule.air) + all(&schedule.step) + all(&schedule.coarse);
    let step = once + u64::from(iterations) * (1 + all(&schedule.relax));
    [step, 4 * each + all(&schedule.gusts) + all(&schedule.frame)]
}

/// Those of a tile of cloths, from [`of_solids`] of their colliders and [`of_ring`] of their seams.
pub fn of_tile(tile: &Tile, [solids, ring]: [u64; 2]) -> u64 {
    let each = each(tile.shape.room[0] * tile.shape.room[1], tile.threads) + 1;
    let of = |pass: &Pass| match over(*pass) {
        Over::Rings => each * ring,
        _ => each * within(pass, solids) + 1,
    };
    let again = if tile.span == TileSpan::Ahead { stages(&tile.passes).arrive } else { &[] };
    2 * each + tile.passes.iter().chain(again).map(of).sum::<u64>()
}

/// Those of a chain, as [`of_tile`]: a thread goes through all duplicates of a seam point.
pub fn of_chain(chain: &Chain, [solids, ring]: [u64; 2]) -> u64 {
    ring * chain.passes.iter().map(|pass| within(pass, solids) + 1).sum::<u64>() + ring
}

/// Of a thread over all particles.
fn each(places: u32, threads: u32) -> u64 {
    u64::from(places.div_ceil(threads.max(1)))
}

/// Of a particle, or of a spring, a texel or a cell.
fn within(pass: &Pass, solids: u64) -> u64 {
    match pass {
        Pass::Contact(_) => 2 + solids,
        Pass::Tethers { slots } => 2 + u64::from(*slots),
        Pass::Gust | Pass::Integrate(Air::Push) | Pass::IntegrateExact(Air::Push) => 1 + GUST,
        Pass::Sew => 2 + u64::from(crate::cloth::MAX_STITCHES_AT_POINT),
        _ if over(*pass) == Over::Texels => 12,
        _ => 1,
    }
}

/// Of a pass over seam rings, whose duplicates are gone through twice.
fn rings(cloth: &Cloth, threads: u32) -> u64 {
    each(cloth.ring_count() as u32, threads) * of_ring(cloth) + 1
}

/// Those of a thread for the longest seam ring of a cloth.
pub fn of_ring(cloth: &Cloth) -> u64 {
    let (starts, _) = cloth.rings();
    u64::from(3 + 2 * starts.windows(2).map(|ends| ends[1] - ends[0]).max().unwrap_or(0))
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::cloth::Flat;
    use crate::form::Form;
    use crate::fused::Room;
    use crate::options::Options;
    use crate::scene::Scene;
    use crate::tuning::Tuning;
    use crate::world::World;

    #[test]
    fn tiles_end_before_contact_with_more_colliders_than_their_loops_have_room_for() {
        let room = Room {
            memory: 65_536,
            threads: 64,
            buffers: 8,
            loops: 16_384,
            busy: 8,
            bytes: 1 << 27,
            whole: u32::MAX,
            cloths: 1,
            tuning: Tuning::NONE,
        };
        let contact = |shape: Shape, count: usize| {
            let mut scene = Scene::new("many");
            scene.cloths.push(Flat::square("sheet", 150).cloth().unwrap());
            scene.colliders = (0..count).map(|k| Collider::new(shape, [k as f32, -1.0, 0.0])).collect();
            let mut world = World::new(scene, Options::default()).unwrap();
            world.make_room(room);
            let first = world.runs[0].sequence.clone().unwrap().first.clone();
            let contact = |p: &Pass| matches!(p, Pass::Contact(_));
            let tiles: Vec<bool> =
                first.iter().map(|f| matches!(f, Form::Tile(t) if t.passes.iter().any(contact))).collect();
            assert_eq!(
                first.iter().filter(|f| matches!(f, Form::Together(p) if contact(p))).count(),
                usize::from(!tiles.contains(&true))
            );
            assert!(first.iter().any(|f| matches!(f, Form::Tile(_))), "springs still run by tiles");
            tiles.contains(&true)
        };
        let ball = || Shape::Sphere { radius: 0.3 };
        let egg = || Shape::Ellipsoid { radii: [0.3, 0.2, 0.1], closest: true };
        assert_eq!([contact(ball(), 8), contact(ball(), 1000)], [true, false]);
        assert_eq!([contact(egg(), 1), contact(egg(), 40)], [true, false]);
    }
}
