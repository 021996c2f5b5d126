//! Pins that a pose puts inside of a body: cloth beside them goes in with them, as far as it reaches.

use std::sync::Arc;

use crate::support::limb::{IDENTITY, THICKNESS, depth, limb};
use crate::support::rig::{FRAME, Rig, largest};
use crate::support::{self, scene};
use gimage_runtime::*;
use parry3d_f64::math::Vector;
use parry3d_f64::shape::{TriMesh, TriMeshFlags};

/// Particles in a row.
const WIDTH: usize = 33;
/// How far the second joint puts pins inside \[m\].
const DEEP: f32 = 0.08;

fn upright() -> (Vec<[f32; 3]>, Vec<[u32; 3]>) {
    limb(0.15, [0.3, -1.0], 48, 60)
}

/// A cape beside an upright limb, pinned by its upper row, of which the right end follows the second joint.
fn cape() -> Cloth {
    let (right, down) = ([0.4, 0.0, 0.0], [0.0, -0.6, 0.0]);
    let flat =
        Flat { width: WIDTH as u32, height: 49, origin: [-0.2, 0.0, 0.16], right, down, ..Flat::square("cape", 2) };
    let mut cloth = flat.cloth().unwrap();
    cloth.pin(&(0..WIDTH as u32).collect::<Vec<_>>()).unwrap();
    let influence = |p: &[f32; 3]| {
        let second = ((p[0] + 0.1) / 0.2).clamp(0.0, 1.0);
        Influence { joints: [0, 1, 0, 0], weights: [1.0 - second, second, 0.0, 0.0] }
    };
    let joint = |n: usize| SkinJoint { name: format!("joint {n}"), inverse_bind: IDENTITY, ..SkinJoint::default() };
    let list: Vec<_> = cloth.positions().iter().map(influence).collect();
    cloth.set_skin((0..2).map(joint).collect(), &list).unwrap();
    let (positions, triangles) = upright();
    let first = Influence { joints: [0; 4], weights: [1.0, 0.0, 0.0, 0.0] };
    let influences = vec![first; positions.len()];
    cloth.set_body(Some(Arc::new(BodySurface::new(positions, triangles, influences).unwrap()))).unwrap();
    (cloth.thickness, cloth.damping) = (Some(THICKNESS), 0.5);
    cloth.follow_joints(&pose(0)).unwrap();
    cloth
}

/// The matrices of a frame: the second joint goes into the limb in half a second.
fn pose(frame: u32) -> Vec<[f32; 16]> {
    let mut second = IDENTITY;
    second[14] = -DEEP * (frame as f32 / 30.0).min(1.0);
    vec![IDENTITY, second]
}

fn step(rig: &mut Rig, frame: u32) {
    rig.stepper.set_joints(0, &pose(frame)).unwrap();
    rig.frame(FRAME);
}

/// By how much the springs down of free particles are longer than at rest: the longest.
fn longest(cloth: &Cloth, now: &[[f32; 4]]) -> f32 {
    let rest = cloth.positions();
    let far = |a: &[f32], b: &[f32]| (0..3).map(|c| (a[c] - b[c]).powi(2)).sum::<f32>().sqrt();
    let down = (0..now.len() - WIDTH).map(|k| [k, k + WIDTH]);
    down.map(|[a, b]| far(&now[a], &now[b]) / far(&rest[a], &rest[b]) - 1.0).fold(0.0, f32::max)
}

#[test]
fn cloth_beside_pins_inside_of_a_body_keeps_its_size() {
    let cloth = cape();
    let (positions, triangles) = upright();
    let positions = positions.iter().map(|p| Vector::from_array(p.map(f64::from))).collect();
    let mesh = TriMesh::with_flags(positions, triangles, TriMeshFlags::ORIENTED).unwrap();
    for mut rig in Rig::both(&scene(cloth.clone()), &Options::default()) {
        let mut worst = 0.0f32;
        for frame in 1..=120 {
            step(&mut rig, frame);
            worst = worst.max(longest(&cloth, &rig.positions(0)));
        }
        // Pushed out, springs are 3.5 times as long as at rest.
        assert!(worst < 0.6, "{}: {worst}", rig.name());
        // Away from pins cloth is outside.
        let mut now = rig.positions(0);
        let above = (0..now.len()).filter(|k| k / WIDTH < (DEEP / 0.0125) as usize + 4);
        above.for_each(|k| now[k] = [0.0, 9.0, 0.0, 1.0]);
        let deep = depth(&mesh, &cloth, &now)[0];
        assert!(deep < 1e-3, "{}: {deep}", rig.name());
    }
}

#[test]
fn a_frame_beside_pins_inside_of_a_body_is_that_of_the_twin() {
    let Some(device) = support::device() else { return };
    let options = Options { substeps: Some(8), polish: Some(1), ..Options::default() };
    let mut rigs = [Rig::cpu(scene(cape()), &options), Rig::gpu(scene(cape()), &options, &device)];
    let mut apart = Vec::new();
    for frame in 1..=40 {
        // Both from where the CPU is.
        let state = rigs[0].stepper.snapshot().unwrap();
        rigs[1].stepper.restore(&state).unwrap();
        rigs[1].stepper.teleport_joints(0, &pose(frame - 1)).unwrap();
        rigs.iter_mut().for_each(|rig| step(rig, frame));
        apart.push(largest(&rigs[0].positions(0), &rigs[1].positions(0)));
    }
    assert!(apart.iter().all(|far| *far < 1e-4), "{apart:?}");
}
