//! How far cloth keeps from what it touches.

use crate::support::rig::{FRAME, Rig, largest};
use crate::support::{self, on_colliders, scene};
use gimage_runtime::*;

const THICK: f32 = 0.02;

fn options(solver: Solver, thickness: f32) -> Options {
    Options { solver, substeps: Some(4), tethers: 0, threads: 1, thickness, ..Options::default() }
}

/// A sheet of particles without springs above a solid, which it falls on.
fn sand(shape: Shape, velocity: f32) -> Scene {
    let flat =
        Flat { origin: [-0.1, 0.35, -0.1], right: [0.2, 0.0, 0.0], down: [0.0, 0.0, 0.2], ..Flat::square("s", 9) };
    let flat = flat.cloth().unwrap();
    let (positions, particles) = (flat.positions().to_vec(), flat.particles().to_vec());
    let (grids, mass) = (flat.grids().to_vec(), Mass::Constant(1e-3));
    let parts = Parts { name: "sand".into(), grids, positions, particles, rest: Rest::None, mass };
    let mut cloth = Cloth::new(parts).unwrap();
    cloth.velocity = [0.0, velocity, 0.0];
    // On its side for capsules, so that all fall on it.
    let rotation = [0.0, 0.0, 0.5f32.sqrt(), 0.5f32.sqrt()];
    let turned = matches!(shape, Shape::Capsule { .. } | Shape::TaperedCapsule { .. });
    let solid = Collider { friction: 0.5, ..Collider::new(shape, [0.0; 3]) };
    let solid = if turned { Collider { rotation, ..solid } } else { solid };
    Scene { colliders: vec![solid], ..scene(cloth) }
}

/// Distance \[m\] from the surface.
fn above(shape: Shape, p: &[f32; 4]) -> f32 {
    match shape {
        Shape::HalfSpace => p[1],
        Shape::Sphere { radius } => (p[0] * p[0] + p[1] * p[1] + p[2] * p[2]).sqrt() - radius,
        Shape::Capsule { half_height, radius } => {
            let x = p[0] - p[0].clamp(-half_height, half_height);
            (x * x + p[1] * p[1] + p[2] * p[2]).sqrt() - radius
        }
        Shape::TaperedCapsule { half_height, radii: [low, high] } => {
            let ball = |k: i16| {
                let (t, x) = (f32::from(k) / 1000.0, p[0] + half_height * (f32::from(k) / 500.0 - 1.0));
                (x * x + p[1] * p[1] + p[2] * p[2]).sqrt() - (low + t * (high - low))
            };
            (0..=1000).map(ball).fold(f32::MAX, f32::min)
        }
        Shape::Box { half } => p[1] - half[1],
        Shape::Ellipsoid { radii, .. } => p[1] - radii[1],
    }
}

const SHAPES: [Shape; 6] = [
    Shape::HalfSpace,
    Shape::Sphere { radius: 0.3 },
    Shape::Capsule { half_height: 0.3, radius: 0.25 },
    Shape::Box { half: [0.3, 0.2, 0.3] },
    Shape::Ellipsoid { radii: [0.4, 0.3, 0.4], closest: true },
    Shape::Ellipsoid { radii: [0.4, 0.3, 0.4], closest: false },
];

#[test]
fn particles_come_to_rest_at_their_thickness_from_every_shape() {
    // At 30 m/s too, which is 0.12 m a step, and under both solvers.
    for (solver, velocity) in [(Solver::Xpbd, -1.0), (Solver::Xpbd, -30.0), (Solver::Classic, -1.0)] {
        for shape in SHAPES {
            for mut rig in Rig::both(&sand(shape, velocity), &options(solver, THICK)) {
                rig.frames(20);
                // The one above the middle has not slid away.
                let middle = above(shape, &rig.positions(0)[40]);
                assert!((middle - THICK).abs() < 2e-5, "{shape:?} at {velocity} m/s, {}: {middle} m", rig.name());
                if !matches!(shape, Shape::Ellipsoid { .. }) {
                    let least = rig.positions(0).iter().map(|p| above(shape, p)).fold(f32::MAX, f32::min);
                    assert!(least > THICK - 2e-5, "{shape:?}, {}: {least} m", rig.name());
                }
            }
        }
    }
}

#[test]
fn without_thickness_not_a_bit_changes_and_with_it_backends_agree() {
    let at_surface = |thickness| {
        let mut rig = Rig::cpu(on_colliders(17), &options(Solver::Xpbd, thickness));
        rig.frames(10);
        rig.positions(0)
    };
    assert!(at_surface(0.0) == at_surface(-0.0) && largest(&at_surface(0.0), &at_surface(THICK)) > 0.01);
    let Some(device) = support::device() else { return };
    for fused in [false, true] {
        let options = Options { fused, substeps: Some(1), step: FRAME / 4.0, ..options(Solver::Xpbd, THICK) };
        let mut cpu = Rig::cpu(on_colliders(17), &options);
        let mut gpu = Rig::gpu(on_colliders(17), &options, &device);
        [&mut cpu, &mut gpu].into_iter().for_each(|rig| rig.frame(FRAME / 4.0));
        let far = largest(&cpu.positions(0), &gpu.positions(0));
        assert!(far < 3e-6, "fused {fused}: {far} m");
    }
}

#[test]
fn friction_holds_as_it_does_without() {
    // A slope of 20 degrees: tan 0.364. More friction holds, less does not.
    let slope = |friction: f32, thickness| {
        let mut scene = sand(Shape::HalfSpace, 0.0);
        let half = 10f32.to_radians();
        let above = |p: &[f32; 3]| [p[0], (thickness + p[0] * (2.0 * half).sin()) / (2.0 * half).cos(), p[2]];
        let start: Vec<_> = scene.cloths[0].positions().iter().map(above).collect();
        scene.cloths[0].place(start).unwrap();
        scene.colliders[0] = Collider { friction, rotation: [0.0, 0.0, half.sin(), half.cos()], ..scene.colliders[0] };
        let mut rig = Rig::cpu(scene, &options(Solver::Xpbd, thickness));
        let start = rig.positions(0);
        rig.frames(60);
        largest(&start, &rig.positions(0))
    };
    for thickness in [0.0, THICK] {
        let (held, slides) = (slope(0.4, thickness), slope(0.3, thickness));
        assert!(held < 1e-4 && slides > 0.1, "{thickness}: {held} {slides}");
    }
}

#[test]
fn it_changes_on_the_way_and_is_checked() {
    for mut rig in Rig::both(&sand(Shape::Sphere { radius: 0.3 }, -1.0), &options(Solver::Xpbd, 0.0)) {
        rig.frames(20);
        let radius = |rig: &Rig| above(Shape::Sphere { radius: 0.3 }, &rig.positions(0)[40]);
        assert!(radius(&rig).abs() < 2e-5);
        rig.stepper.set_options(Options { thickness: THICK, ..rig.stepper.options().clone() }).unwrap();
        rig.frames(20);
        assert!(radius(&rig) > THICK - 2e-5, "{}", radius(&rig));
    }
    for wrong in [-1e-3, 1.5, f32::NAN] {
        assert!(options(Solver::Xpbd, wrong).check().is_err(), "{wrong}");
    }
}
