//! Cloths that keep different distances from the same colliders, and slide on them differently.

use crate::support::rig::{FRAME, Rig, largest};
use crate::support::{self, all_colliders, device_with, scene};
use gimage_runtime::*;

fn options(thickness: f32) -> Options {
    Options { substeps: Some(4), tethers: 0, threads: 1, thickness, ..Options::default() }
}

const RADIUS: f32 = 0.3;

/// Particles without springs above a sphere, a cloth for each thickness.
fn sand(thicknesses: &[Option<f32>]) -> Scene {
    let flat =
        Flat { origin: [-0.1, 0.4, -0.1], right: [0.2, 0.0, 0.0], down: [0.0, 0.0, 0.2], ..Flat::square("s", 9) };
    let flat = flat.cloth().unwrap();
    let (positions, particles) = (flat.positions().to_vec(), flat.particles().to_vec());
    let (grids, mass) = (flat.grids().to_vec(), Mass::Constant(1e-3));
    let parts = Parts { name: "sand".into(), grids, positions, particles, rest: Rest::None, mass };
    let mut all = Scene::new("sand");
    for thickness in thicknesses {
        let mut cloth = Cloth::new(parts.clone()).unwrap();
        (cloth.thickness, cloth.velocity) = (*thickness, [0.0, -1.0, 0.0]);
        all.cloths.push(cloth);
    }
    all.colliders = vec![Collider { friction: 0.5, ..Collider::new(Shape::Sphere { radius: RADIUS }, [0.0; 3]) }];
    all
}

/// Distance \[m\] of the particle above the middle from the sphere.
fn above(rig: &Rig, cloth: usize) -> f32 {
    let [x, y, z, _] = rig.positions(cloth)[40];
    (x * x + y * y + z * z).sqrt() - RADIUS
}

#[test]
fn every_cloth_rests_at_its_own_distance() {
    let all = sand(&[Some(0.01), None, Some(0.0), Some(0.03), Some(0.01)]);
    for solver in [Solver::Xpbd, Solver::Classic] {
        for mut rig in Rig::both(&all, &Options { solver, ..options(0.02) }) {
            rig.frames(20);
            for (cloth, wanted) in [0.01, 0.02, 0.0, 0.03, 0.01].into_iter().enumerate() {
                let found = above(&rig, cloth);
                assert!((found - wanted).abs() < 2e-5, "{}, {wanted} m: {found} m", rig.name());
            }
        }
    }
}

#[test]
fn thickness_of_one_is_that_of_all_by_bits() {
    for (own, of_all) in [(Some(0.02), 0.0), (Some(0.0), 0.02), (Some(-0.0), 0.02)] {
        let [mut own_rigs, mut all_rigs] =
            [(own, of_all), (None, own.unwrap())].map(|(own, of_all)| Rig::both(&sand(&[own, own]), &options(of_all)));
        for (a, b) in own_rigs.iter_mut().zip(&mut all_rigs) {
            [&mut *a, &mut *b].into_iter().for_each(|rig| rig.frames(15));
            assert!(a.positions(1) == b.positions(1) && a.previous(1) == b.previous(1), "{own:?} {}", a.name());
        }
    }
}

#[test]
fn coats_follow_options_and_colliders_on_the_way() {
    let start = sand(&[None, Some(0.01), None]);
    for mut rig in Rig::both(&start, &options(0.01)) {
        // One coat, then two, then one of another number of colliders.
        rig.frames(20);
        assert!((0..3).all(|c| (above(&rig, c) - 0.01).abs() < 2e-5), "{}", rig.name());
        rig.stepper.set_options(Options { thickness: 0.02, ..rig.stepper.options().clone() }).unwrap();
        // Cloth that gets thicker at once is thrown up, and falls.
        rig.frames(50);
        let found = [0, 1, 2].map(|c| above(&rig, c));
        assert!((found[0] - 0.02).abs() < 2e-5 && (found[2] - 0.02).abs() < 2e-5, "{}: {found:?}", rig.name());
        assert!((found[1] - 0.01).abs() < 2e-5, "{}: {found:?}", rig.name());
        let far = Collider::new(Shape::Sphere { radius: 0.1 }, [9.0, 0.0, 0.0]);
        rig.stepper.set_colliders([vec![far; 17], start.colliders.clone()].concat()).unwrap();
        rig.stepper.set_options(Options { thickness: 0.03, ..rig.stepper.options().clone() }).unwrap();
        rig.frames(50);
        let found = [0, 1, 2].map(|c| above(&rig, c));
        assert!((found[0] - 0.03).abs() < 2e-5 && (found[2] - 0.03).abs() < 2e-5, "{}: {found:?}", rig.name());
        rig.stepper.set_options(Options { thickness: 0.01, ..rig.stepper.options().clone() }).unwrap();
        rig.stepper.set_colliders(start.colliders.clone()).unwrap();
        rig.frames(2);
        assert!(above(&rig, 1) > 0.01 - 2e-5);
    }
}

#[test]
fn friction_of_both_is_the_product() {
    let square = || Flat { origin: [0.0, 0.01, 0.0], ..Flat::square("flat", 13) }.cloth().unwrap();
    let falls = |of_cloth: f32, of_collider: f32| {
        let mut cloth = square();
        (cloth.velocity, cloth.friction) = ([0.6, -1.0, 0.2], of_cloth);
        let colliders = all_colliders().into_iter().map(|c| Collider { friction: of_collider, ..c });
        Scene { colliders: colliders.collect(), ..scene(cloth) }
    };
    for solver in [Solver::Xpbd, Solver::Classic] {
        let run = |scene: Scene| {
            let rigs = Rig::both(&scene, &Options { solver, ..options(0.0) });
            let moved = rigs.into_iter().map(|mut rig| {
                rig.frames(12);
                rig.positions(0)
            });
            moved.collect::<Vec<_>>()
        };
        let (half, none, rough) = (run(falls(0.5, 0.8)), run(falls(0.0, 0.8)), run(falls(1.0, 0.8)));
        assert!(half == run(falls(1.0, 0.4)) && none == run(falls(1.0, 0.0)), "{solver:?}");
        assert!(largest(&half[0], &none[0]) > 1e-3 && largest(&half[0], &rough[0]) > 1e-3, "{solver:?}");
    }
    let mut cloth = square();
    cloth.friction = 1e6;
    let rough = all_colliders().into_iter().map(|c| Collider { friction: f32::MAX, ..c }).collect();
    let mut rig = Rig::cpu(Scene { colliders: rough, ..scene(cloth) }, &options(0.0));
    rig.frames(5);
    assert!(rig.positions(0).as_flattened().iter().all(|x| x.is_finite()) && rig.stepper.take_faults().is_empty());
}

/// Flat cloths of `n` x `n` particles about to fall on colliders, each with a coat of its own but for the last two.
fn coated(n: u32, colliders: Vec<Collider>) -> Scene {
    let mut all = Scene { colliders, ..Scene::new("coated") };
    for (thickness, friction) in
        [(Some(0.0), 1.0), (Some(0.013), 0.3), (None, 1.0), (Some(0.04), 0.0), (Some(0.0), 2.0), (None, 1.0)]
    {
        let mut cloth = Flat { origin: [0.0, 0.03, 0.0], ..Flat::square("flat", n) }.cloth().unwrap();
        (cloth.thickness, cloth.friction) = (thickness, friction);
        (cloth.velocity, cloth.damping) = ([0.1, -1.5, 0.0], 0.2);
        all.cloths.push(cloth);
    }
    all
}

#[test]
fn cloths_of_all_coats_share_a_dispatch_and_move_as_alone() {
    let (Some(roomy), Some(small)) = (device_with(device_limits), support::device()) else { return };
    let many: Vec<_> = all_colliders().into_iter().cycle().take(18).collect();
    // Whole frames in one dispatch, tiles, and passes of their own under either solver.
    let kinds =
        [(17, true, Solver::Xpbd), (40, true, Solver::Xpbd), (17, false, Solver::Xpbd), (17, false, Solver::Classic)];
    for (colliders, (n, fused, solver)) in
        [all_colliders()[1..2].to_vec(), many].iter().flat_map(|c| kinds.map(|k| (c, k)))
    {
        let device = if n == 17 { &roomy } else { &small };
        let scene = coated(n, colliders.clone());
        let with = |fused| Options { fused, solver, ..options(0.02) };
        let mut all = Rig::gpu(scene.clone(), &with(fused), device);
        let (name, plan) = (format!("{n} {fused} {solver:?} {}", colliders.len()), all.stepper.plan());
        let is_fused = plan.passes.iter().any(|p| matches!(p.form, Form::Whole(_)));
        let is_tiled = plan.passes.iter().any(|p| matches!(p.form, Form::Tile(_)));
        assert_eq!((is_fused, is_tiled), (fused && n == 17, fused && n == 40), "{name}");
        let own = plan.passes.iter().filter(|p| p.dispatches > 0).count();
        assert!(!is_fused || own == 1, "{name}: {plan}");
        all.frames(6);
        let places: Vec<_> = (0..scene.cloths.len()).map(|c| all.positions(c)).collect();
        for (index, cloth) in scene.cloths.iter().enumerate() {
            let alone = Scene { cloths: vec![cloth.clone()], ..scene.clone() };
            let mut rig = Rig::gpu(alone, &with(false), device);
            rig.frames(6);
            assert!(places[index] == rig.positions(0), "{name}: cloth {index}");
        }
        assert!(places[2] == places[5] && (0..2).all(|c| places[c] != places[4] && places[c] != places[3]), "{name}");
        // A step each, before rounding grows.
        let once = Options { substeps: Some(1), step: FRAME / 4.0, ..with(fused) };
        let (mut there, mut here) = (Rig::gpu(scene.clone(), &once, device), Rig::cpu(scene.clone(), &once));
        for _ in 0..4 {
            [&mut there, &mut here].into_iter().for_each(|rig| rig.frame(FRAME / 4.0));
            let apart = (0..scene.cloths.len()).map(|c| largest(&there.positions(c), &here.positions(c)));
            let apart = apart.fold(0.0, f32::max);
            assert!(apart < 3e-6, "{name}: {apart} m");
            if colliders.len() > 1 {
                break;
            }
        }
    }
}

#[test]
fn wrong_coats_are_refused_and_materials_have_them() {
    let cloth = || Flat::square("flat", 5).cloth().unwrap();
    for wrong in [-1e-3, 1.5, f32::NAN] {
        let mut thick = cloth();
        thick.thickness = Some(wrong);
        assert!(thick.check().unwrap_err().to_string().contains("thickness"), "{wrong}");
        assert!(Stepper::new(scene(thick), options(0.0), None).is_err());
    }
    for wrong in [-0.1, 2e6, f32::INFINITY] {
        let mut rough = cloth();
        rough.friction = wrong;
        assert!(rough.check().unwrap_err().to_string().contains("friction"), "{wrong}");
    }
    let mut made = cloth();
    made.thickness = Some(0.01);
    made.set_material(&Material::default()).unwrap();
    assert_eq!((made.thickness, made.friction), (Some(0.01), 1.0));
    made.set_material(&Material { thickness: Some(0.25), friction: 0.5, ..Material::default() }).unwrap();
    assert_eq!((made.thickness, made.friction), (Some(0.25), 0.5));
    for wrong in
        [Material { thickness: Some(-1.0), ..Material::default() }, Material { friction: -1.0, ..Material::default() }]
    {
        assert!(made.set_material(&wrong).is_err());
    }
}
