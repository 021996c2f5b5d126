//! A skinned garment follows an animation of its file, from the file to the cloth.

use gimage::colliders::{ColliderOptions, ColliderSource, Form, fit_colliders};
use gimage::import::{Character, ImportOptions};
use gimage::options::BuildOptions;
use gimage_bundle::{Bundle, MapKind, Particle};
use gimage_runtime::{Backend, Cloth, Options, Scene, Stepper};
use gimage_tests::glb::Glb;
use gimage_tests::{asset, build, check, pinned, reread};
use serde_json::json;

type Matrix = [[f64; 4]; 3];

fn times(a: &Matrix, b: &Matrix) -> Matrix {
    let last = [0.0, 0.0, 0.0, 1.0];
    let row = |r: &[f64; 4], c: usize| (0..4).map(|k| r[k] * b.get(k).unwrap_or(&last)[c]).sum();
    [0, 1, 2].map(|r| [0, 1, 2, 3].map(|c| row(&a[r], c)))
}

fn shift(x: f64, y: f64) -> Matrix {
    [[1.0, 0.0, 0.0, x], [0.0, 1.0, 0.0, y], [0.0, 0.0, 1.0, 0.0]]
}

/// The joint matrices of `swing` at a time, from its keys: the shoulder turns about z by angles that are linear in time; the elbow turns
/// about y by a unit quaternion on a spline whose tangents are 0.
fn swing(time: f64) -> [Matrix; 3] {
    let keys = [0.0, -0.5, -0.8, -0.5, 0.0, -0.5];
    let (key, s) = ((time * 4.0).floor(), (time * 4.0).fract());
    let angle = keys[key as usize] + (keys[key as usize + 1] - keys[key as usize]) * s;
    let (sin, cos) = angle.sin_cos();
    let about_z = [[cos, -sin, 0.0, 0.0], [sin, cos, 0.0, 0.0], [0.0, 0.0, 1.0, 0.0]];
    let s = if time < 0.5 { 2.0 * time } else { 2.0 - 2.0 * time };
    let to = 3.0 * s * s - 2.0 * s * s * s;
    let (y, w) = (to * (-0.6f64).sin(), 1.0 - to + to * 0.6f64.cos());
    let (sin, cos) = (2.0 * y.atan2(w)).sin_cos();
    let about_y = [[cos, 0.0, sin, 0.0], [0.0, 1.0, 0.0, 0.0], [-sin, 0.0, cos, 0.0]];
    let shoulder = times(&shift(0.2, 1.4), &about_z);
    let elbow = times(&times(&shoulder, &shift(0.25, 0.0)), &about_y);
    let wrist = times(&elbow, &shift(0.25, 0.0));
    let rest = [0.2, 0.45, 0.7].map(|x| shift(-x, -1.4));
    [times(&shoulder, &rest[0]), times(&elbow, &rest[1]), times(&wrist, &rest[2])]
}

/// The sleeve, pinned at both ends.
fn sleeve() -> Bundle {
    let ends = ["box:0.1,1,-1,0.205,2,1", "box:0.695,1,-1,0.8,2,1"];
    let built = build(&asset("sleeve.glb"), &pinned(1500, &ends)).unwrap();
    check("sleeve.glb", &built);
    assert!(!built.report.has_findings(), "{:?}", built.report.findings);
    reread(&built.bundle)
}

/// Where the maps of a bundle say that a texel is by some joint matrices.
fn skinned(bundle: &Bundle, k: usize, matrices: &[Matrix; 3]) -> [f64; 3] {
    let at = |kind| bundle.image(0, &kind).unwrap().at(k);
    let (p, joints, weights) = (at(MapKind::Position), at(MapKind::Joints(0)), at(MapKind::Weights(0)));
    let p = [0, 1, 2].map(|c| f64::from(p[c]));
    let one = |m: &Matrix, r: usize| m[r][0] * p[0] + m[r][1] * p[1] + m[r][2] * p[2] + m[r][3];
    let all = || joints.iter().zip(weights).map(|(j, w)| (&matrices[*j as usize], f64::from(*w)));
    [0, 1, 2].map(|r| all().map(|(m, w)| w * one(m, r)).sum())
}

#[test]
fn the_sleeve_swings_with_its_arm_and_its_pins_stay_on_the_skin() {
    let bundle = sleeve();
    let character = Character::read(&asset("sleeve.glb"), "swing", &ImportOptions::default()).unwrap();
    assert_eq!((character.seconds(), character.loops()), (1.0, true));
    let mut cloth = Cloth::from_bundle("sleeve", &bundle).unwrap();
    let skin = cloth.skin().unwrap().clone();
    let names: Vec<_> = skin.joints().iter().map(|j| j.name.as_str()).collect();
    assert_eq!(names, ["shoulder", "elbow", "wrist"]);
    let nodes: Vec<usize> = names.iter().map(|n| character.node(n).unwrap()).collect();
    let joints = |time: f64| {
        let worlds = character.worlds(time);
        skin.matrices(&nodes.iter().map(|n| worlds[*n].map(|x| x as f32)).collect::<Vec<_>>()).unwrap()
    };
    // The animation begins in the pose of the file: so does the cloth.
    cloth.follow_joints(&joints(0.0)).unwrap();
    for (k, p) in cloth.positions().iter().enumerate() {
        let rest = skinned(&bundle, k, &swing(0.0));
        assert!((0..3).all(|c| (f64::from(p[c]) - rest[c]).abs() < 1e-6), "{p:?}, not {rest:?}");
    }
    let mut scene = Scene::new("sleeve");
    scene.cloths.push(cloth);
    let options = Options { backend: Backend::Cpu, ..Options::default() };
    let mut stepper = Stepper::on_cpu(scene, options).unwrap();
    let pins: Vec<usize> = (bundle.particles().unwrap().iter().enumerate())
        .filter(|(_, p)| matches!(p, Particle::Pinned { .. }))
        .map(|(k, _)| k)
        .collect();
    assert!(pins.len() > 20, "{}", pins.len());
    let (mut farthest, mut moved) = (0.0f64, 0.0f64);
    // Past the end of the animation, which repeats.
    for frame in 1..=90 {
        let time = f64::from(frame) / 60.0;
        stepper.set_joints(0, &joints(time)).unwrap();
        stepper.advance(1.0 / 60.0).unwrap();
        let (matrices, positions) = (swing(time.rem_euclid(1.0)), stepper.positions(0).unwrap());
        for k in &pins {
            let to = skinned(&bundle, *k, &matrices);
            let far = (0..3).map(|c| (f64::from(positions[*k][c]) - to[c]).powi(2)).sum::<f64>().sqrt();
            farthest = farthest.max(far);
            let rest = bundle.position(*k as u32).unwrap();
            moved = moved.max((0..3).map(|c| (to[c] - f64::from(rest[c])).powi(2)).sum::<f64>().sqrt());
        }
        assert!(positions.iter().flatten().all(|x| x.is_finite()));
    }
    assert!(farthest < 1e-5, "a pin is {farthest} m off the skin");
    assert!(moved > 0.3, "the wrist moves by {moved} m");
    assert!(stepper.take_faults().is_empty());
}

#[test]
fn a_step_jumps_and_a_scale_grows() {
    let pull = Character::read(&asset("sleeve.glb"), "pull", &ImportOptions::default()).unwrap();
    assert!(!pull.loops());
    let wrist = pull.node("wrist").unwrap();
    // The elbow at x = 0.45 grows from 1 to 1.2 in a second; the wrist is 0.25 beyond it, 0.28 from half a second on.
    for (time, x) in [(0.0, 0.7), (0.4, 0.45 + 1.08 * 0.25), (0.5, 0.45 + 1.1 * 0.28), (3.0, 0.45 + 1.2 * 0.28)] {
        let at = pull.worlds(time)[wrist];
        assert!((at[12] - x).abs() < 1e-6 && (at[13] - 1.4).abs() < 1e-6, "{time}: {at:?}, not {x}");
        assert!((at[0] - (1.0 + 0.2 * time.min(1.0))).abs() < 1e-6, "{at:?}");
    }
}

#[test]
fn patterns_of_cloth_that_match_nothing_are_errors_beside_a_body_that_is_named() {
    let mut read = BuildOptions::default();
    read.select.body = vec!["Body".parse().unwrap()];
    let fit = |read: &BuildOptions| fit_colliders(&asset("figure.glb"), read, &ColliderOptions::default());
    for wrong in ["Typo", "Body"] {
        read.select.cloth = vec![wrong.parse().unwrap()];
        let error = fit(&read).map(|_| ()).unwrap_err().to_string();
        assert!(error.contains(wrong), "{error}");
    }
    read.select.cloth = Vec::new();
    assert!(fit(&read).is_ok());
}

#[test]
fn colliders_of_a_file_are_where_its_nodes_are() {
    let folder = tempfile::tempdir().unwrap();
    let path = folder.path().join("arm.glb");
    let mut glb = Glb::read(&asset("sleeve.glb"));
    {
        let file = &mut glb.json;
        file["nodes"][3]["children"] = json!([4]);
        let rigid = json!({"KHR_physics_rigid_bodies": {"collider": {"geometry": {"shape": 0}}}});
        let nodes = file["nodes"].as_array_mut().unwrap();
        nodes.push(json!({"name": "hand", "translation": [0.1, 0, 0], "scale": [0.5, 0.5, 0.5], "extensions": rigid}));
        file["extensions"] = json!({
            "KHR_implicit_shapes": {"shapes": [{"type": "box", "box": {"size": [0.2, 0.1, 0.1]}}]},
            "VRMC_springBone": {"colliders": [
                {"node": 1, "shape": {"capsule": {"offset": [0, 0, 0], "tail": [0.25, 0, 0], "radius": 0.05}}},
            ]},
            "VRM": {"secondaryAnimation": {"colliderGroups": [
                {"node": 2, "colliders": [{"offset": {"x": 0.1, "y": 0, "z": 0.02}, "radius": 0.04}]},
            ]}},
        });
        file["extensionsUsed"] = json!(["KHR_implicit_shapes", "KHR_physics_rigid_bodies", "VRM", "VRMC_springBone"]);
    }
    glb.write(&path);
    let mut read = BuildOptions::default();
    read.select.body = vec!["sleeve".parse().unwrap()];
    let options = ColliderOptions { source: ColliderSource::File, ..ColliderOptions::default() };
    // In centimetres they are as near to the body.
    for unit in [1.0, 0.01] {
        read.import.unit = unit;
        let fit = fit_colliders(&path, &read, &options).unwrap();
        let found: Vec<_> = fit.colliders.iter().map(|c| (c.joint.as_deref(), c.solid.form, c.solid.center)).collect();
        let expected = [
            (Some("wrist"), Form::Box { half: [0.05, 0.025, 0.025] }, [0.8, 1.4, 0.0]),
            (Some("shoulder"), Form::Capsule { half_height: 0.125, radius: 0.05 }, [0.325, 1.4, 0.0]),
            (Some("elbow"), Form::Sphere { radius: 0.04 }, [0.55, 1.4, -0.02]),
        ];
        for ((joint, form, center), e) in found.iter().zip(&expected) {
            let sizes = |form: &Form| match *form {
                Form::Sphere { radius } => vec![radius],
                Form::Capsule { half_height, radius } => vec![half_height, radius],
                Form::TaperedCapsule { half_height, radii: [low, high] } => vec![half_height, low, high],
                Form::Box { half } => half.to_vec(),
                Form::Ellipsoid { radii } => radii.to_vec(),
            };
            assert_eq!((joint, std::mem::discriminant(form)), (&e.0, std::mem::discriminant(&e.1)));
            let pairs = sizes(form).into_iter().zip(sizes(&e.1)).chain(center.iter().copied().zip(e.2));
            pairs.for_each(|(is, should)| assert!((is - unit * should).abs() < 1e-6 * unit, "{found:?}"));
        }
        assert_eq!(found.len(), expected.len());
        // The capsule lies along the arm.
        let arm = &fit.colliders[1].solid;
        assert!(arm.distance([0.575 * unit, 1.45 * unit, 0.0]) > 0.0);
        assert!(arm.distance([0.45 * unit, 1.45 * unit, 0.0]).abs() < 1e-6);
    }
    let contents = gimage::contents::list(&path, &BuildOptions::default()).unwrap();
    assert_eq!(contents.colliders.len(), 3);
}
