use super::*;
use crate::error::Error;

pub(crate) fn sample() -> Manifest {
    let mut manifest = Manifest::new("gimage 0.1.0");
    manifest.options.insert("texels".into(), 16384.into());
    manifest.options.insert("pin".into(), Value::Null);
    let mut piece = PieceEntry { name: "body".into(), width: 3, height: 2, ..PieceEntry::default() };
    piece.constants.rest = Some([0.1, 0.2, 0.3, 0.3]);
    piece.quality.psnr = Some(81.123_456_789_012_35);
    piece.maps.insert("position".into(), "body.position.exr".into());
    manifest.pieces.push(piece);
    let inverse_bind = [0.1; 16];
    manifest.skeleton = Some(Skeleton { joints: vec![Joint { name: "hip".into(), parent: None, inverse_bind }] });
    manifest
}

#[test]
fn bytes_and_back_and_bytes() {
    let manifest = sample();
    let bytes = manifest.to_bytes().unwrap();
    let read = Manifest::from_bytes(&bytes).unwrap();
    assert_eq!(read, manifest);
    assert_eq!(read.to_bytes().unwrap(), bytes);
}

#[test]
fn unknown_fields_are_ignored() {
    let mut value: Value = serde_json::from_slice(&sample().to_bytes().unwrap()).unwrap();
    value["tomorrow"] = 1.into();
    value["pieces"][0]["tomorrow"] = "x".into();
    Manifest::from_bytes(value.to_string().as_bytes()).unwrap();
}

#[test]
fn other_versions_and_formats_are_refused_by_name() {
    for version in ["2", "0", "\"1\"", "1.5", "null", "-1"] {
        let text = format!(r#"{{"format": "gimage-bundle", "version": {version}, "pieces": 7}}"#);
        let error = Manifest::from_bytes(text.as_bytes()).unwrap_err();
        assert!(matches!(error, Error::Version { .. }), "{version}: {error}");
    }
    for text in ["", "{}", "[]", r#"{"format": "gltf", "version": 1}"#, r#"{"format": "gimage-bundle", "version": 1}"#]
    {
        assert!(Manifest::from_bytes(text.as_bytes()).is_err(), "{text}");
    }
}

#[test]
fn numbers_that_are_not_finite_are_named() {
    let mut manifest = sample();
    manifest.pieces[0].quality.rms = Some(f64::NAN);
    let error = manifest.to_bytes().unwrap_err().to_string();
    assert!(error.contains("pieces[0].quality.rms"), "{error}");
    let mut manifest = sample();
    manifest.skeleton.as_mut().unwrap().joints[0].inverse_bind[3] = f32::INFINITY;
    assert!(manifest.to_bytes().unwrap_err().to_string().contains("skeleton.joints[0].inverse_bind[3]"));
}

#[test]
fn contradictions_are_refused() {
    type Change = fn(&mut Manifest);
    let broken: [(&str, Change); 7] = [
        ("range", |m| m.pieces[0].first_particle = 1),
        ("size", |m| m.pieces[0].width = 20_000),
        ("cannot hold a surface", |m| m.pieces[0].height = 1),
        ("path", |m| drop(m.pieces[0].maps.insert("mass".into(), "../m.exr".into()))),
        ("twice", |m| drop(m.pieces[0].maps.insert("mass".into(), "body.position.exr".into()))),
        ("parent", |m| m.skeleton.as_mut().unwrap().joints[0].parent = Some(0)),
        ("units", |m| m.units = "inch".into()),
    ];
    for (what, break_it) in broken {
        let mut manifest = sample();
        break_it(&mut manifest);
        assert!(manifest.to_bytes().is_err(), "{what}");
        let bytes = serde_json::to_vec(&manifest).unwrap();
        assert!(Manifest::from_bytes(&bytes).is_err(), "{what}");
    }
}

#[test]
fn too_many_particles_are_refused() {
    let mut manifest = sample();
    manifest.pieces.clear();
    for k in 0..3 {
        let first_particle = k * 4096 * 2048;
        let size = PieceEntry { width: 4096, height: 2048, ..PieceEntry::default() };
        manifest.pieces.push(PieceEntry { name: k.to_string(), first_particle, ..size });
    }
    assert!(matches!(manifest.check().unwrap_err(), Error::TooLarge { .. }));
}

#[test]
fn mutations_do_not_panic() {
    let bytes = sample().to_bytes().unwrap();
    let mut state = 99_u64;
    let mut next = |n: usize| {
        state = state.wrapping_mul(6_364_136_223_846_793_005).wrapping_add(1_442_695_040_888_963_407);
        (state >> 33) as usize % n
    };
    for _ in 0..4000 {
        let mut mutated = bytes.clone();
        for _ in 0..1 + next(3) {
            let at = next(mutated.len());
            mutated[at] = b"0123456789eE-+.,:[]{}\"\\n \xff"[next(26)];
        }
        if let Ok(manifest) = Manifest::from_bytes(&mutated) {
            let _ = manifest.to_bytes();
        }
    }
    let deep = "[".repeat(100_000);
    assert!(Manifest::from_bytes(deep.as_bytes()).is_err());
}
