//! Limits of particles: how far each may be from its position at rest.

use crate::support::{scene, tube};
use gimage_runtime::*;

/// A tube with a seam that falls; its upper rows are limited, the more the higher.
fn sleeve() -> Cloth {
    let mut cloth = tube(17, 12, 1);
    let limit = |k: usize| match k / 17 {
        0 => 0.0,
        row @ 1..=7 => 0.01 * row as f32,
        _ => -1.0,
    };
    cloth.limits = Some((0..cloth.len()).map(limit).collect());
    cloth
}

fn options() -> Options {
    Options { backend: Backend::Cpu, ..Options::default() }
}

fn from_start(cloth: &Cloth, positions: &[[f32; 4]], k: usize) -> f32 {
    (0..3).map(|c| (positions[k][c] - cloth.positions()[k][c]).powi(2)).sum::<f32>().sqrt()
}

#[test]
fn no_particle_leaves_its_limit_and_free_ones_fall() {
    let cloth = sleeve();
    let limits = cloth.limits.clone().unwrap();
    let mut stepper = Stepper::on_cpu(scene(cloth.clone()), options()).unwrap();
    let mut farthest = vec![0f32; cloth.len()];
    for _ in 0..90 {
        stepper.advance(1.0 / 60.0).unwrap();
        let positions = stepper.positions(0).unwrap();
        farthest.iter_mut().enumerate().for_each(|(k, far)| *far = far.max(from_start(&cloth, positions, k)));
    }
    for (k, (far, limit)) in farthest.iter().zip(limits.iter()).enumerate() {
        assert!(*limit < 0.0 || *far <= limit + 1e-6, "{k}: {far} of {limit}");
    }
    assert!(farthest[..17].iter().all(|far| *far < 1e-6), "a limit of 0 holds");
    assert!(farthest[17..34].iter().any(|far| *far > 0.005), "limits leave room");
    // Without limits nothing holds the tube.
    let mut free = Stepper::on_cpu(scene(tube(17, 12, 1)), options()).unwrap();
    (0..90).for_each(|_| _ = free.advance(1.0 / 60.0).unwrap());
    assert!(from_start(&cloth, free.positions(0).unwrap(), 0) > 1.0);
}

#[test]
fn limits_are_a_pass_of_their_own_and_cost_nothing_without() {
    let count = |cloth: Cloth| {
        let plan = Stepper::on_cpu(scene(cloth), options()).unwrap().plan();
        plan.passes.iter().filter(|p| p.form.pass() == Some(Pass::Limit { moves: false })).count()
    };
    assert_eq!((count(sleeve()), count(tube(17, 12, 1))), (1, 0));
}

#[test]
fn limits_that_cannot_hold_are_errors() {
    let fails = |change: fn(&mut Vec<f32>)| {
        let mut cloth = sleeve();
        let mut limits = cloth.limits.as_deref().unwrap().to_vec();
        change(&mut limits);
        cloth.limits = Some(limits.into());
        Stepper::on_cpu(scene(cloth), options()).map(|_| ()).unwrap_err().to_string()
    };
    assert!(fails(|limits| _ = limits.pop()).contains("number of limits"));
    assert!(fails(|limits| limits[3] = f32::NAN).contains("limit"));
    assert!(fails(|limits| limits[17] = 0.5).contains("seam duplicates"));
}

#[test]
fn a_bundle_brings_its_limits() {
    let flat = Flat::square("flat", 4).cloth().unwrap();
    let mut bundle = gimage_bundle::Bundle::new("test");
    bundle.add_piece("flat", 4, 4).unwrap();
    let free = Particle::Free { next: None }.code().unwrap();
    let data = flat.positions().iter().flat_map(|p| [p[0], p[1], p[2], free]).collect();
    let image = gimage_bundle::Image { width: 4, height: 4, channels: 4, data };
    bundle.insert(0, gimage_bundle::MapKind::Position, image).unwrap();
    assert_eq!(Cloth::from_bundle("flat", &bundle).unwrap().limits, None);
    bundle.manifest.pieces[0].constants.limit = Some(0.25);
    assert_eq!(Cloth::from_bundle("flat", &bundle).unwrap().limits, Some(vec![0.25; 16].into()));
}

/// In separate passes, by tiles and in whole frames: the same bits, and those of the twin to rounding.
#[cfg(feature = "gpu")]
#[test]
fn every_form_has_the_same_limits() {
    use crate::support::rig::Rig;
    use crate::support::run::Run;
    let Some(device) = crate::support::device_with(device_limits) else { return };
    // Too large for a workgroup.
    let mut sheet = Flat::square("sheet", 70).cloth().unwrap();
    sheet.limits = Some((0..sheet.len()).map(|k| if k % 70 < 9 { 0.002 * (k % 70) as f32 } else { -1.0 }).collect());
    for (cloth, whole) in [(sleeve(), true), (sheet, false)] {
        let mut scene = scene(cloth);
        scene.colliders = crate::support::all_colliders();
        let gpu = |fused| Options { backend: Backend::Gpu, fused, ..options() };
        let runs = [true, false].map(|fused| Run::new(&scene, &gpu(fused), &device));
        assert_eq!((runs[0].holds().is_empty(), runs[0].tiles().is_empty()), (!whole, whole));
        let [fused, apart] = runs.map(|run| run.frames(5).bits(0));
        assert!(fused == apart);
        // Friction would make rounding grow.
        scene.colliders.clear();
        let mut rigs = [Rig::cpu(scene.clone(), &options()), Rig::gpu(scene.clone(), &gpu(true), &device)];
        rigs.iter_mut().for_each(|rig| rig.frames(2));
        let far = crate::support::rig::largest(&rigs[0].positions(0), &rigs[1].positions(0));
        assert!(far < 1e-4, "{far}");
    }
}
