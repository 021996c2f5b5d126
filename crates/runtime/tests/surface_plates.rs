//! Cloth on plates, whose two sides are near each other and no crease: each backend has what its twin has.

use std::sync::Arc;

use crate::support::limb::{IDENTITY, THICKNESS};
use crate::support::rig::{FRAME, Rig, largest};
use crate::support::{self, scene};
use gimage_runtime::*;

fn fixed() -> Options {
    Options { substeps: Some(8), polish: Some(1), ..Options::default() }
}

/// Boxes of `side` x 1 cm x `side` \[m\], each in a joint of its own, their middles at these heights \[m\].
fn plates(side: f32, heights: &[f32]) -> BodySurface {
    let (mut positions, mut triangles, mut influences) = (Vec::new(), Vec::new(), Vec::new());
    for (joint, height) in heights.iter().enumerate() {
        let first = positions.len() as u32;
        let sign = |k: u32, bit: u32| if k >> bit & 1 == 1 { 1.0 } else { -1.0 };
        let corner = |k| [0.5 * side * sign(k, 0), height + 0.005 * sign(k, 1), 0.5 * side * sign(k, 2)];
        positions.extend((0..8).map(corner));
        influences.extend([Influence { joints: [joint as u32, 0, 0, 0], weights: [1.0, 0.0, 0.0, 0.0] }; 8]);
        for q in [[0, 4, 6, 2], [1, 3, 7, 5], [0, 1, 5, 4], [2, 6, 7, 3], [0, 2, 3, 1], [4, 5, 7, 6]] {
            triangles.extend([[q[0], q[1], q[2]], [q[0], q[2], q[3]]].map(|t: [u32; 3]| t.map(|v| first + v)));
        }
    }
    BodySurface::new(positions, triangles, influences).unwrap()
}

/// The largest difference of the backends in two frames from one state, for each of 60 frames, and where the particles are then. `rise` gives how far
/// \[m\] each joint has gone up in a frame.
fn beside_twin(
    device: &(wgpu::Device, wgpu::Queue),
    cloth: Cloth,
    rise: impl Fn(u32) -> Vec<f32>,
) -> (f32, Vec<[f32; 4]>) {
    let pose = |frame: u32| -> Vec<[f32; 16]> {
        let up = |y: &f32| {
            let mut matrix = IDENTITY;
            matrix[13] = *y;
            matrix
        };
        rise(frame).iter().map(up).collect()
    };
    let mut rigs = [Rig::cpu(scene(cloth.clone()), &fixed()), Rig::gpu(scene(cloth), &fixed(), device)];
    let mut far = 0.0f32;
    for frame in (0..120).step_by(2) {
        let state = rigs[0].stepper.snapshot().unwrap();
        rigs[1].stepper.restore(&state).unwrap();
        rigs.iter_mut().for_each(|rig| rig.stepper.teleport_joints(0, &pose(frame)).unwrap());
        // A state has no hints: the first frame begins with a search, the second goes on from it.
        for next in [frame + 1, frame + 2] {
            rigs.iter_mut().for_each(|rig| {
                rig.stepper.set_joints(0, &pose(next)).unwrap();
                rig.frame(FRAME);
            });
        }
        far = far.max(largest(&rigs[0].positions(0), &rigs[1].positions(0)));
    }
    (far, rigs[0].positions(0))
}

/// A sheet of `size` \[m\], some height above the origin, that meets plates, each in a joint of its own.
fn over_plates(n: u32, size: f32, height: f32, plates: BodySurface, joints: usize) -> Cloth {
    let flat = Flat {
        origin: [-0.5 * size, height, -0.5 * size],
        right: [size, 0.0, 0.0],
        down: [0.0, 0.0, size],
        ..Flat::square("sheet", n)
    };
    let mut cloth = flat.cloth().unwrap();
    cloth.thickness = Some(THICKNESS);
    let own = vec![Influence { joints: [0; 4], weights: [1.0, 0.0, 0.0, 0.0] }; cloth.len()];
    let joint = |n: usize| SkinJoint { name: format!("joint {n}"), inverse_bind: IDENTITY, ..SkinJoint::default() };
    cloth.set_skin((0..joints).map(joint).collect(), &own).unwrap();
    cloth.set_body(Some(Arc::new(plates))).unwrap();
    cloth.follow_joints(&vec![IDENTITY; joints]).unwrap();
    cloth
}

#[test]
fn cloth_around_the_edges_of_a_plate_is_that_of_the_twin() {
    let Some(device) = support::device() else { return };
    // Particles on one side of it know the other side from their neighbours.
    let cloth = over_plates(28, 1.0, 0.01, plates(0.3, &[0.0]), 1);
    let (far, now) = beside_twin(&device, cloth, |_| vec![0.0]);
    assert!(far < 2e-5, "{far:e}");
    // It lies on the plate, hangs over its edges, and is nowhere in it.
    let at_plate = || now.iter().filter(|p| p[0].abs() < 0.14 && p[2].abs() < 0.14);
    let on_top = at_plate().filter(|p| (0.004..0.02).contains(&p[1])).count();
    let lowest = now.iter().map(|p| p[1]).fold(f32::INFINITY, f32::min);
    assert!(on_top > 40 && lowest < -0.15 && at_plate().all(|p| p[1].abs() > 0.005), "{on_top} {lowest}");
}

#[test]
fn cloth_between_plates_that_close_is_that_of_the_twin() {
    let Some(device) = support::device() else { return };
    // 3 cm apart at rest; the upper one comes down until it is 4 mm inside of the lower one, with the sheet between them.
    let cloth = over_plates(20, 0.2, 0.01, plates(0.3, &[0.0, 0.04]), 2);
    let (far, _) = beside_twin(&device, cloth, |frame| vec![0.0, -0.034 * (frame as f32 / 40.0).min(1.0)]);
    assert!(far < 2e-5, "{far:e}");
}
