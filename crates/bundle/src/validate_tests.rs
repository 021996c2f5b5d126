use super::*;
use crate::bundle::tests::sample;

fn set(bundle: &mut Bundle, kind: MapKind, k: usize, c: usize, value: f32) {
    let image = bundle.images.get_mut(&(0, kind)).unwrap();
    image.data[k * image.channels as usize + c] = value;
}

#[test]
fn a_sound_bundle_has_no_faults() {
    assert_eq!(validate(&sample()), []);
    assert_eq!(exit_code(&[]), 0);
    let files = sample().encode().unwrap();
    let (_, faults) = validate_files(|name, _| Ok(files[name].clone())).unwrap();
    assert_eq!(faults, []);
    assert_eq!(sample().seam_gap().unwrap(), 0.0);
}

#[test]
fn every_rule_is_checked_and_the_place_named() {
    use FaultKind::*;
    type Change = fn(&mut Bundle);
    let cases: [(FaultKind, (u32, u32), Change); 16] = [
        (Code, (1, 0), |b| set(b, MapKind::Position, 1, 3, 1.5)),
        (Code, (0, 0), |b| set(b, MapKind::Position, 0, 3, f32::NAN)),
        (Ring, (0, 0), |b| set(b, MapKind::Position, 0, 3, 900.0)),
        (Ring, (0, 0), |b| set(b, MapKind::Position, 0, 3, 2.0)),
        (Ring, (0, 0), |b| set(b, MapKind::Position, 0, 3, 3.0)),
        (Pin, (3, 0), |b| set(b, MapKind::Position, 0, 3, -5.0)),
        (NotFinite, (1, 1), |b| set(b, MapKind::Position, 5, 0, f32::INFINITY)),
        (NotFinite, (2, 1), |b| set(b, MapKind::Uv(1), 6, 1, f32::NAN)),
        (Seam, (3, 1), |b| set(b, MapKind::Position, 7, 1, 1.000_000_1)),
        (Seam, (3, 2), |b| set(b, MapKind::Mass, 11, 0, 0.02)),
        (Mass, (1, 0), |b| set(b, MapKind::Mass, 1, 0, 0.0)),
        (Rest, (3, 0), |b| set(b, MapKind::Rest, 3, 0, 0.5)),
        (Rest, (1, 0), |b| set(b, MapKind::Rest, 1, 3, 0.5)),
        (Rest, (0, 0), |b| set(b, MapKind::Rest, 0, 0, -0.5)),
        (Joint, (1, 0), |b| set(b, MapKind::Joints(0), 1, 2, 1.0)),
        (Weight, (1, 0), |b| set(b, MapKind::Weights(0), 1, 2, 0.5)),
    ];
    for (kind, texel, break_it) in cases {
        let mut bundle = sample();
        break_it(&mut bundle);
        let faults = validate(&bundle);
        let named = |f: &Fault| f.kind == kind && f.texel == Some(texel) && f.piece.as_deref() == Some("tube");
        assert!(faults.iter().any(named), "{kind:?} {texel:?}: {faults:#?}");
        assert_eq!(exit_code(&faults), 1);
    }
}

#[test]
fn tethers_hold_to_pinned_particles() {
    let with = |anchor: f32| {
        let mut bundle = sample();
        let mut tether = Image::zeros(4, 3, 3);
        for texel in tether.data.chunks_exact_mut(3) {
            texel.copy_from_slice(&[0.5, anchor, 0.0]);
        }
        bundle.insert(0, MapKind::Tether, tether).unwrap();
        validate(&bundle).iter().filter(|f| f.kind == FaultKind::Tether).count()
    };
    // Particle 12 is the pinned corner of the second piece.
    assert_eq!((with(12.0), with(-1.0)), (0, 0));
    for bad in [13.0, 12.5, -2.0, 1e9] {
        assert_eq!(with(bad), 12, "{bad}");
    }
}

#[test]
fn limits_are_finite_and_agree_in_rings_with_maps_and_constants() {
    let with = |change: &dyn Fn(&mut Bundle)| {
        let mut bundle = sample();
        let mut limit = Image::zeros(4, 3, 1);
        limit.data.fill(0.05);
        bundle.insert(0, MapKind::Limit, limit).unwrap();
        change(&mut bundle);
        validate(&bundle).iter().map(|f| (f.kind, f.texel)).collect::<Vec<_>>()
    };
    assert_eq!(with(&|_| {}), []);
    assert_eq!(with(&|b| set(b, MapKind::Limit, 5, 0, -1.0)), []);
    assert_eq!(with(&|b| set(b, MapKind::Limit, 5, 0, f32::NAN)), [(FaultKind::NotFinite, Some((1, 1)))]);
    assert_eq!(with(&|b| set(b, MapKind::Limit, 3, 0, 0.050_000_01)), [(FaultKind::Seam, Some((3, 0)))]);
    let both = with(&|b| b.manifest.pieces[0].constants.limit = Some(0.05));
    assert_eq!(both, [(FaultKind::Manifest, None)]);
    assert_eq!(with(&|b| b.manifest.pieces[1].constants.limit = Some(f32::INFINITY)), [(FaultKind::NotFinite, None)]);
    // A ring that leads from a piece with a limit to one without.
    let mut bundle = sample();
    let code = |next| crate::Particle::Free { next: Some(next) }.code().unwrap();
    set(&mut bundle, MapKind::Position, 1, 3, code(13));
    let flag = bundle.images.get_mut(&(1, MapKind::Position)).unwrap();
    let at = sample().position(1).unwrap();
    flag.data[4..8].copy_from_slice(&[at[0], at[1], at[2], code(1)]);
    bundle.count().unwrap();
    let seams = |bundle: &Bundle| validate(bundle).iter().filter(|f| f.message.starts_with("limit differs")).count();
    assert_eq!(seams(&bundle), 0);
    bundle.manifest.pieces[0].constants.limit = Some(0.05);
    assert_eq!(seams(&bundle), 1);
    bundle.manifest.pieces[1].constants.limit = Some(0.05);
    assert_eq!(seams(&bundle), 0);
}

#[test]
fn a_hole_needs_rest_lengths_of_zero_around_it() {
    let mut bundle = sample();
    set(&mut bundle, MapKind::Position, 5, 3, 0.0);
    let faults = validate(&bundle);
    assert!(faults.iter().any(|f| f.kind == FaultKind::Rest && f.texel == Some((0, 1))), "{faults:#?}");
    assert!(faults.iter().any(|f| f.kind == FaultKind::Count && f.message.contains("particles")));
}

#[test]
fn long_lists_are_cut_short() {
    let mut bundle = sample();
    bundle.images.get_mut(&(0, MapKind::Rest)).unwrap().data.fill(-1.0);
    let faults: Vec<_> = validate(&bundle).into_iter().filter(|f| f.kind == FaultKind::Rest).collect();
    assert_eq!(faults.len(), MAX_LISTED + 1);
    assert_eq!(faults[MAX_LISTED].message, "and 28 more of this kind");
}

#[test]
fn manifest_and_shapes_are_checked() {
    let breaks: [fn(&mut Bundle); 6] = [
        |b| b.manifest.pieces[1].first_particle = 3,
        |b| b.manifest.pieces[0].constants.mass = Some(1.0),
        |b| b.manifest.pieces[0].counts.springs = 1,
        |b| drop(b.images.remove(&(0, MapKind::Position))),
        |b| drop(b.images.insert((7, MapKind::Mass), Image::zeros(2, 2, 1))),
        |b| b.images.get_mut(&(0, MapKind::Mass)).unwrap().data.truncate(3),
    ];
    for break_it in breaks {
        let mut bundle = sample();
        break_it(&mut bundle);
        assert!(!validate(&bundle).is_empty());
    }
}

#[test]
fn files_that_cannot_be_read_are_exit_code_2_and_changed_ones_1() {
    let files = sample().encode().unwrap();
    let mut cut = files.clone();
    cut.get_mut("tube.mass.exr").unwrap().truncate(300);
    let (_, faults) = validate_files(|name, _| Ok(cut[name].clone())).unwrap();
    assert_eq!((faults.len(), faults[0].file.as_str(), exit_code(&faults)), (1, "tube.mass.exr", 2));

    let mut bundle = sample();
    set(&mut bundle, MapKind::Position, 7, 1, 9.0);
    let mut changed = files.clone();
    changed.insert("tube.position.exr".into(), bundle.encode().unwrap()["tube.position.exr"].clone());
    let (_, faults) = validate_files(|name, _| Ok(changed[name].clone())).unwrap();
    let kinds: Vec<_> = faults.iter().map(|f| f.kind).collect();
    assert_eq!(kinds, [FaultKind::Checksum, FaultKind::Seam]);
    assert_eq!(exit_code(&faults), 1);
}

#[test]
fn sizes_places_and_rotations_of_colliders_are_checked() {
    let solid = |shape: &str, x: f64, turn: f64| {
        let text = format!(r#"{{"shape": {shape}, "position": [{x}, 0, 0], "rotation": [0, 0, 0, {turn}]}}"#);
        serde_json::from_str(&text).unwrap()
    };
    let sphere = r#"{"sphere": {"radius": 0.1}}"#;
    let cases = [
        (sphere, 0.0, 1.0, 0),
        (r#"{"sphere": {"radius": 0}}"#, 0.0, 1.0, 1),
        (r#"{"capsule": {"half_height": 0.1, "radius": -0.1}}"#, 0.0, 1.0, 1),
        (r#"{"box": {"half": [0.1, 0.1, 1e30]}}"#, 0.0, 1.0, 1),
        (r#"{"ellipsoid": {"radii": [1e7, 0.1, 0.1]}}"#, 0.0, 1.0, 1),
        (r#"{"cone": {"radius": -1}}"#, 0.0, 1.0, 0),
        (sphere, 1e39, 1.0, 1),
        (sphere, 0.0, 0.9, 1),
    ];
    for (shape, x, turn, count) in cases {
        let mut bundle = sample();
        bundle.manifest.colliders = vec![solid(sphere, 0.0, 1.0), solid(shape, x, turn)];
        let faults = validate(&bundle);
        let named = |f: &Fault| f.kind == FaultKind::Manifest && f.message.starts_with("collider 1: ");
        assert_eq!((faults.len(), faults.iter().filter(|f| named(f)).count()), (count, count), "{shape}: {faults:?}");
        assert_eq!(exit_code(&faults), u8::from(count > 0));
    }
}
