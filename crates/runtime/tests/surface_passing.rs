//! Cloth on the surface of a body of which a part comes to it in one frame.

use std::sync::Arc;

use crate::support::limb::{IDENTITY, THICKNESS, depth, limb};
use crate::support::rig::{FRAME, Rig};
use crate::support::{self, scene};
use gimage_runtime::*;
use parry3d_f64::math::Vector;
use parry3d_f64::shape::{TriMesh, TriMeshFlags};

/// A leg that rests, and a heel that is a component of its own.
fn leg_and_heel() -> (Vec<[f32; 3]>, Vec<[u32; 3]>, Vec<Influence>) {
    let (mut positions, mut triangles) = limb(0.06, [0.5, -0.5], 24, 60);
    let mut joints = vec![0; positions.len()];
    let (heel, faces) = limb(0.05, [0.08, -0.08], 16, 16);
    let first = positions.len() as u32;
    positions.extend(heel.iter().map(|[x, y, z]| [*x, *y - 0.3, *z]));
    triangles.extend(faces.into_iter().map(|t| t.map(|v| v + first)));
    joints.resize(positions.len(), 1);
    let weights = [1.0, 0.0, 0.0, 0.0];
    (positions, triangles, joints.into_iter().map(|j| Influence { joints: [j, 0, 0, 0], weights }).collect())
}

/// The heel kicks by 0.4 m four times a second: at up to 5 m/s, or 84 mm per frame, nearly its own width.
fn kick(time: f32) -> Vec<[f32; 16]> {
    let mut heel = IDENTITY;
    heel[14] = 0.12 + 0.2 * (1.0 - (8.0 * std::f32::consts::PI * time).cos());
    vec![IDENTITY, heel]
}

/// A curtain behind the leg, pinned at its top.
fn curtain() -> Cloth {
    let mut cloth = Flat {
        origin: [-0.4, 0.4, 0.2],
        right: [0.8, 0.0, 0.0],
        down: [0.0, -0.9, 0.0],
        ..Flat::square("curtain", 41)
    }
    .cloth()
    .unwrap();
    cloth.pin(&(0..41).collect::<Vec<_>>()).unwrap();
    let joint = |n: usize| SkinJoint { name: format!("joint {n}"), inverse_bind: IDENTITY, ..SkinJoint::default() };
    let own = vec![Influence { joints: [0; 4], weights: [1.0, 0.0, 0.0, 0.0] }; cloth.len()];
    cloth.set_skin((0..2).map(joint).collect(), &own).unwrap();
    let (positions, triangles, influences) = leg_and_heel();
    cloth.set_body(Some(Arc::new(BodySurface::new(positions, triangles, influences).unwrap()))).unwrap();
    cloth.thickness = Some(THICKNESS);
    cloth.damping = 0.5;
    cloth.follow_joints(&kick(0.0)).unwrap();
    cloth
}

#[test]
fn a_heel_that_goes_by_in_one_frame_pushes_cloth_aside() {
    let cloth = curtain();
    let mut rigs = vec![Rig::cpu(scene(cloth.clone()), &Options::default())];
    rigs.extend(support::device().map(|device| Rig::gpu(scene(cloth.clone()), &Options::default(), &device)));
    for rig in &mut rigs {
        let (mut deepest, mut pushed) = (Vec::new(), 0.0f32);
        for frame in 1..=60 {
            let matrices = kick(frame as f32 * FRAME as f32);
            rig.stepper.set_joints(0, &matrices).unwrap();
            rig.frame(FRAME);
            let (positions, triangles, influences) = leg_and_heel();
            let moved = |(p, i): (&[f32; 3], &Influence)| {
                let shift = matrices[i.joints[0] as usize][14];
                Vector::new(p[0].into(), p[1].into(), (p[2] + shift).into())
            };
            let vertices = positions.iter().zip(&influences).map(moved).collect();
            let mesh = TriMesh::with_flags(vertices, triangles, TriMeshFlags::ORIENTED).unwrap();
            let now = rig.positions(0);
            deepest.push(depth(&mesh, &cloth, &now)[0]);
            pushed = now.iter().map(|p| p[2]).fold(pushed, f32::max);
        }
        deepest.sort_by(f64::total_cmp);
        assert!(pushed > 0.45, "the heel pushes the curtain: {pushed}");
        // By the point alone that is nearest at the start of a frame, six frames are 9 to 22 mm deep.
        assert!(deepest[56] < 1e-3 && deepest[59] < 0.012, "{:?}", &deepest[50..]);
    }
}
