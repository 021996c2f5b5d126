//! Tapered capsules as colliders: of scene files and of bundles, and under a cloth.

use crate::support;
use gimage_bundle::Bundle;
use gimage_bundle::manifest::{ColliderEntry, ColliderShape};
use gimage_runtime::*;

/// Distance \[m\] of a point from the hull of two balls along x, of 0.2 m at x = 0.2 m and of 0.08 m at x = 0.8 m.
fn height(p: &[f32; 4]) -> f64 {
    let [x, y, z] = [p[0], p[1] + 0.3, p[2] - 0.5].map(f64::from);
    let ball = |k: usize| {
        let t = k as f64 / 2000.0;
        let (at, radius) = (0.2 + 0.6 * t, 0.2 - 0.12 * t);
        ((x - at).powi(2) + y * y + z * z).sqrt() - radius
    };
    (0..=2000).map(ball).fold(f64::INFINITY, f64::min)
}

/// The capsule of [`height`], turned from y to x.
fn capsule() -> Collider {
    let h = 0.5f32.sqrt();
    let shape = Shape::TaperedCapsule { half_height: 0.3, radii: [0.2, 0.08] };
    Collider { rotation: [0.0, 0.0, -h, h], friction: 0.5, ..Collider::new(shape, [0.5, -0.3, 0.5]) }
}

#[test]
fn cloth_lies_on_a_tapered_capsule_and_not_in_it() {
    let scene = Scene { colliders: vec![capsule()], ..support::scene(Flat::square("sheet", 24).cloth().unwrap()) };
    let mut stepper = Stepper::on_cpu(scene, Options { threads: 1, ..Options::default() }).unwrap();
    let mut touched = 0;
    for _ in 0..90 {
        stepper.advance(1.0 / 60.0).unwrap();
        for p in stepper.positions(0).unwrap() {
            let height = height(p);
            // The judge takes 2,001 balls for all of them.
            assert!(height > -2e-6, "{p:?} is {height} m inside");
            touched += u32::from(height < 0.004);
        }
    }
    assert!(touched > 1000, "{touched}");
    assert!(stepper.take_faults().is_empty());
}

#[cfg(feature = "scene-file")]
#[test]
fn scene_files_have_them() {
    let read = |radii: &str| {
        let text = format!(
            r#"{{"format": "gimage-scene", "version": 1, "duration": 1, "cloths": [{{"from": {{"flat": {{"width": 5, "height": 5, "right": [1, 0, 0], "down": [0, 0, 1]}}}}}}], "colliders": [
            {{"shape": {{"tapered_capsule": {{"half_height": 0.3, "radii": {radii}}}}}, "position": [0, -1, 0]}}]}}"#
        );
        scene::file::SceneFile::parse(text.as_bytes(), |_| Err("no such bundle".into()))
    };
    let shape = read("[0.2, 0.08]").unwrap().scene.colliders[0].shape;
    assert_eq!(shape, Shape::TaperedCapsule { half_height: 0.3, radii: [0.2, 0.08] });
    for radii in ["[0.2]", "[0.2, -0.1]", "[0.1, 0.8]"] {
        let refused = match read(radii) {
            Err(_) => true,
            Ok(file) => Stepper::on_cpu(file.scene, Options::default()).is_err(),
        };
        assert!(refused, "{radii}");
    }
}

#[test]
fn bundles_have_them() {
    let bundle = |radii: [f64; 2]| {
        let shape = ColliderShape::TaperedCapsule { half_height: 0.3, radii };
        let mut bundle = Bundle::new("a test");
        bundle.manifest.colliders = vec![ColliderEntry {
            joint: None,
            shape,
            position: [0.0; 3],
            rotation: [0.0, 0.0, 0.0, 1.0],
            guessed: false,
        }];
        bundle
    };
    let found = BodyCollider::of_bundle(&bundle([0.2, 0.08]));
    assert_eq!(found[0].collider.shape, Shape::TaperedCapsule { half_height: 0.3, radii: [0.2, 0.08] });
    assert_eq!(bundle([0.2, 0.08]).manifest.colliders[0].fault(), None);
    assert!(bundle([0.1, 0.8]).manifest.colliders[0].fault().unwrap().contains("differ"));
}
