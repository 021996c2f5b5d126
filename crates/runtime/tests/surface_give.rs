//! A body that would stretch cloth between its pins without end: contact gives way, and the cloth comes free. Cloth with a cut is not taken for that.

use std::sync::Arc;

use crate::support::limb::{IDENTITY, THICKNESS, depth, limb};
use crate::support::rig::{FRAME, Rig, largest};
use crate::support::{self, scene};
use gimage_runtime::*;
use parry3d_f64::math::Vector;
use parry3d_f64::shape::{TriMesh, TriMeshFlags};

/// Particles in a row, and rows.
const WIDTH: u32 = 25;
const HEIGHT: u32 = 13;
/// Of the limb, and of a thinner one.
const RADIUS: f32 = 0.15;
const THIN: f32 = 0.039;
/// How far \[m\] it goes in a second: cloth that went along would be more than twice as long as at rest.
const FAR: f32 = 0.8;

/// An upright limb, `wide` times as wide as it is thick.
fn upright(radius: f32, wide: f32) -> (Vec<[f32; 3]>, Vec<[u32; 3]>) {
    let (positions, triangles) = limb(radius, [0.6, -0.6], 24, 24);
    (positions.iter().map(|[x, y, z]| [wide * x, *y, *z]).collect(), triangles)
}

/// A curtain `before` \[m\] the axis of a limb that the second joint moves, with its left column pinned, and the right one if it is held on `both` sides.
fn curtain(before: f32, both: bool) -> Cloth {
    worn_on(upright(RADIUS, 1.0), before, both)
}

fn worn_on((positions, triangles): (Vec<[f32; 3]>, Vec<[u32; 3]>), before: f32, both: bool) -> Cloth {
    let (right, down) = ([0.6, 0.0, 0.0], [0.0, -0.5, 0.0]);
    let origin = [-0.3, 0.25, before];
    let flat = Flat { width: WIDTH, height: HEIGHT, origin, right, down, ..Flat::square("curtain", 2) };
    let mut cloth = flat.cloth().unwrap();
    let columns: &[u32] = if both { &[0, WIDTH - 1] } else { &[0] };
    let pins = (0..HEIGHT).flat_map(|j| columns.iter().map(move |i| j * WIDTH + i));
    cloth.pin(&pins.collect::<Vec<_>>()).unwrap();
    let joint = |n: usize| SkinJoint { name: format!("joint {n}"), inverse_bind: IDENTITY, ..SkinJoint::default() };
    let of = |weights| Influence { joints: [0, 1, 0, 0], weights };
    cloth.set_skin((0..2).map(joint).collect(), &vec![of([1.0, 0.0, 0.0, 0.0]); cloth.len()]).unwrap();
    let influences = vec![of([0.0, 1.0, 0.0, 0.0]); positions.len()];
    cloth.set_body(Some(Arc::new(BodySurface::new(positions, triangles, influences).unwrap()))).unwrap();
    (cloth.thickness, cloth.damping) = (Some(THICKNESS), 0.5);
    cloth.follow_joints(&pose([0.0; 3])).unwrap();
    cloth
}

/// A curtain that lies on a limb and sticks to it, so that the limb carries it away.
fn caught(compliance: Compliance) -> Scene {
    let mut cloth = curtain(RADIUS + THICKNESS, false);
    (cloth.friction, cloth.compliance) = (1e6, compliance);
    Scene { gravity: [0.0, 0.0, -9.81], ..scene(cloth) }
}

fn pose(by: [f32; 3]) -> Vec<[f32; 16]> {
    let mut second = IDENTITY;
    second[12..15].copy_from_slice(&by);
    vec![IDENTITY, second]
}

/// Where the limb is after some frames: to the right of where it was.
fn away(frame: u32) -> [f32; 3] {
    [(FAR * frame as f32 / 60.0).min(FAR), 0.0, 0.0]
}

fn step(rig: &mut Rig, by: [f32; 3]) {
    rig.stepper.set_joints(0, &pose(by)).unwrap();
    rig.frame(FRAME);
}

/// By how much the springs of free particles along rows are longer than at rest: the longest.
fn longest(cloth: &Cloth, now: &[[f32; 4]]) -> f32 {
    let rest = cloth.positions();
    let far = |a: &[f32], b: &[f32]| (0..3).map(|c| (a[c] - b[c]).powi(2)).sum::<f32>().sqrt();
    let along = (0..now.len() - 1).filter(|k| !(*k as u32 + 1).is_multiple_of(WIDTH));
    along.map(|k| far(&now[k], &now[k + 1]) / far(&rest[k], &rest[k + 1]) - 1.0).fold(0.0, f32::max)
}

fn options() -> Options {
    Options { substeps: Some(8), polish: Some(1), ..Options::default() }
}

/// The longest spring half a second after the limb has stopped.
fn after(rig: &mut Rig) -> f32 {
    (1..=90).for_each(|frame| step(rig, away(frame)));
    longest(&curtain(0.0, false), &rig.positions(0))
}

#[test]
fn cloth_that_a_body_would_tear_comes_free() {
    for mut rig in Rig::both(&caught(Compliance::None), &options()) {
        let end = after(&mut rig);
        assert!(end < 0.5, "{}: {end}", rig.name());
    }
}

#[test]
fn contact_does_not_give_way_to_cloth_that_is_meant_to_stretch() {
    let end = after(&mut Rig::cpu(caught(Compliance::Constant(1e-7)), &options()));
    assert!(end > 1.0, "{end}");
}

#[test]
fn a_frame_in_which_contact_gives_way_is_that_of_the_twin() {
    let Some(device) = support::device() else { return };
    let scene = || caught(Compliance::None);
    let mut rigs = [Rig::cpu(scene(), &options()), Rig::gpu(scene(), &options(), &device)];
    let mut apart = Vec::new();
    for frame in 1..=60 {
        // Both from where the CPU is.
        let state = rigs[0].stepper.snapshot().unwrap();
        rigs[1].stepper.restore(&state).unwrap();
        rigs[1].stepper.teleport_joints(0, &pose(away(frame - 1))).unwrap();
        rigs.iter_mut().for_each(|rig| step(rig, away(frame)));
        apart.push(largest(&rigs[0].positions(0), &rigs[1].positions(0)));
    }
    // A particle in the middle between two sides of the limb may leave by either: by rounding, few frames differ more.
    apart.sort_by(f32::total_cmp);
    assert!(apart[56] < 1e-5 && apart[59] < 2e-3, "{apart:?}");
}

/// A curtain in which a flat limb comes to be at once: of neighbours in a row, one is before the middle of it, the other behind. No particle is deep enough to be left inside.
fn impaled() -> Scene {
    let mut cloth = worn_on(upright(THIN, 4.0), 0.3, true);
    let at = |(k, p): (usize, &[f32; 3])| [p[0], p[1], p[2] + if k % 2 == 0 { 0.01 } else { -0.01 }];
    cloth.place(cloth.positions().iter().enumerate().map(at).collect()).unwrap();
    Scene { gravity: [0.0; 3], ..scene(cloth) }
}

#[test]
fn contact_gives_way_between_neighbours_on_both_sides_of_a_thin_part() {
    for mut rig in Rig::both(&impaled(), &options()) {
        rig.stepper.teleport_joints(0, &pose([0.0, 0.0, 0.3])).unwrap();
        let mut frame = || {
            step(&mut rig, [0.0, 0.0, 0.3]);
            longest(&curtain(0.3, true), &rig.positions(0))
        };
        // The first frame parts them.
        let [parted, then] = [frame(), frame()];
        assert!(parted > 2.2 && then < 1.8, "{}: {parted} {then}", rig.name());
    }
}

/// The sides of a cut that slide off a limb stay outside of it, however far their particles are from one another then.
#[test]
fn the_sides_of_a_cut_stay_outside_of_a_body() {
    let cloth = curtain(RADIUS + THICKNESS, true);
    let (positions, triangles) = upright(RADIUS, 1.0);
    let positions = positions.iter().map(|p| Vector::new(p[0].into(), p[1].into(), p[2].into())).collect();
    let mesh = TriMesh::with_flags(positions, triangles, TriMeshFlags::ORIENTED).unwrap();
    let falls = Scene { gravity: [0.0, 0.0, -9.81], ..scene(cloth.clone()) };
    let found = Rig::both(&falls, &options()).into_iter().map(|mut rig| {
        rig.frame(FRAME);
        rig.stepper.cut([0.005, 0.0, 1.0], [0.005, 1.0, 0.0], [0.005, -1.0, 0.0]).unwrap();
        let deepest = (0..60).map(|_| {
            rig.frame(FRAME);
            depth(&mesh, &cloth, &rig.positions(0))[0]
        });
        let deepest = deepest.fold(0.0, f64::max);
        let row = (HEIGHT / 2 * WIDTH) as usize..((HEIGHT / 2 + 1) * WIDTH) as usize;
        let gap = rig.positions(0)[row].windows(2).map(|p| p[1][0] - p[0][0]).fold(0.0, f32::max);
        (rig.name(), gap, deepest)
    });
    let found: Vec<_> = found.collect();
    assert!(found.iter().all(|(_, gap, deepest)| *gap > RADIUS && *deepest < 1e-3), "{found:?}");
}
