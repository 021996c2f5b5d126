use super::*;
use crate::Particle;
use crate::manifest::{Joint, Skeleton};

/// A sound bundle: a 4 x 3 sheet whose left and right columns are sewn together, and a plain pinned 2 x 2.
pub(crate) fn sample() -> Bundle {
    let mut bundle = Bundle::new("gimage test");
    let tube = bundle.add_piece("tube", 4, 3).unwrap();
    let flag = bundle.add_piece("Flag/1", 2, 2).unwrap();
    let mut position = Image::zeros(4, 3, 4);
    for j in 0..3_u32 {
        for i in 0..4_u32 {
            let k = j * 4 + i;
            let next = match i {
                0 => Some(k + 3),
                3 => Some(k - 3),
                _ => None,
            };
            let angle = (i % 3) as f32 * 2.0;
            let texel = [angle.cos(), j as f32, angle.sin(), Particle::Free { next }.code().unwrap()];
            position.data[k as usize * 4..][..4].copy_from_slice(&texel);
        }
    }
    let mut rest = Image::zeros(4, 3, 4);
    for j in 0..3 {
        for i in 0..4 {
            let lengths = [(i < 3, 0.5), (j < 2, 1.0), (i < 3 && j < 2, 1.1), (i < 3 && j > 0, 1.1)];
            for (c, (inside, length)) in lengths.into_iter().enumerate() {
                rest.data[(j * 4 + i) * 4 + c] = if inside { length } else { 0.0 };
            }
        }
    }
    let ones = |channels: u32, value: f32| {
        let mut image = Image::zeros(4, 3, channels);
        image.data.fill(value);
        image
    };
    bundle.insert(tube, MapKind::Position, position).unwrap();
    bundle.insert(tube, MapKind::Rest, rest).unwrap();
    bundle.insert(tube, MapKind::Mass, ones(1, 0.01)).unwrap();
    bundle.insert(tube, MapKind::Uv(1), ones(3, 0.5)).unwrap();
    bundle.insert(tube, MapKind::Joints(0), ones(4, 0.0)).unwrap();
    bundle.insert(tube, MapKind::Weights(0), ones(4, 0.25)).unwrap();
    bundle.insert(tube, MapKind::Custom("_A b".into()), ones(1, 2.0)).unwrap();
    bundle.insert(tube, MapKind::Custom("_A_B".into()), ones(3, 2.0)).unwrap();
    let mut square = Image::zeros(2, 2, 4);
    for (k, texel) in square.data.chunks_exact_mut(4).enumerate() {
        texel.copy_from_slice(&[(k % 2) as f32, -((k / 2) as f32), 0.0, if k == 0 { -1.0 } else { 1.0 }]);
    }
    bundle.insert(flag, MapKind::Position, square).unwrap();
    bundle.manifest.pieces[flag].constants.rest = Some([1.0, 1.0, 1.5, 1.5]);
    bundle.manifest.pieces[flag].constants.mass = Some(0.02);
    let joint = Joint { name: "hip".into(), parent: None, inverse_bind: [0.0; 16] };
    bundle.manifest.skeleton = Some(Skeleton { joints: vec![joint] });
    bundle.count().unwrap();
    bundle
}

#[test]
fn files_and_back_and_files() {
    let bundle = sample();
    let files = bundle.encode().unwrap();
    assert_eq!(files, bundle.encode().unwrap());
    let read = Bundle::from_files(&files).unwrap();
    assert_eq!(read.images, bundle.images);
    assert_eq!(read.encode().unwrap(), files);
    let maps = &read.manifest.pieces[0].maps;
    assert_eq!(maps["position"], "tube.position.exr");
    assert_eq!(maps["uv1"], "tube.uv1.exr");
    assert_eq!((maps["_A b"].as_str(), maps["_A_B"].as_str()), ("tube._A_b.exr", "tube._A_B_2.exr"));
    assert_eq!(read.manifest.pieces[1].maps["position"], "Flag_1.position.exr");
    assert_eq!(read.manifest.pieces[1].first_particle, 12);
}

#[test]
fn images_that_do_not_fit_are_refused() {
    let mut bundle = sample();
    let refused = |bundle: &mut Bundle, piece, kind, image| bundle.insert(piece, kind, image).unwrap_err().to_string();
    assert!(refused(&mut bundle, 9, MapKind::Mass, Image::zeros(4, 3, 1)).contains("no piece"));
    assert!(refused(&mut bundle, 0, MapKind::Mass, Image::zeros(3, 4, 1)).contains("3 x 4"));
    assert!(refused(&mut bundle, 0, MapKind::Mass, Image::zeros(4, 3, 3)).contains("3 channels"));
    assert!(refused(&mut bundle, 0, MapKind::Custom("mass".into()), Image::zeros(4, 3, 1)).contains("underscore"));
    let short = Image { data: vec![0.0; 5], ..Image::zeros(4, 3, 1) };
    assert!(refused(&mut bundle, 0, MapKind::Mass, short).contains("5 floats"));
    bundle.images.remove(&(1, MapKind::Position));
    assert!(bundle.encode().unwrap_err().to_string().contains("position"));
}

#[test]
fn a_changed_missing_or_swapped_file_is_named() {
    let files = sample().encode().unwrap();
    let mut changed = files.clone();
    *changed.get_mut("tube.mass.exr").unwrap().last_mut().unwrap() ^= 1;
    assert!(Bundle::from_files(&changed).unwrap_err().to_string().contains("tube.mass.exr"));

    let mut missing = files.clone();
    missing.remove("tube.rest.exr");
    assert!(matches!(Bundle::from_files(&missing).unwrap_err(), Error::Missing { file } if file == "tube.rest.exr"));

    let mut swapped = files.clone();
    swapped.insert("tube.position.exr".into(), files["Flag_1.position.exr"].clone());
    let error = Bundle::from_files(&swapped).unwrap_err();
    assert!(matches!(&error, Error::Size { .. }), "{error}");

    let cut = files["tube.mass.exr"][..200].to_vec();
    swapped.insert("tube.mass.exr".into(), cut);
    let read = |name: &str, _| swapped.get(name).cloned().ok_or(Error::Missing { file: name.into() });
    let (bundle, faults) = Bundle::decode_lenient(read).unwrap();
    assert_eq!(faults.len(), 2, "{faults:?}");
    assert_eq!(bundle.images.len(), sample().images.len() - 2);
}

#[test]
fn maps_of_a_later_version_are_passed_over() {
    let mut files = sample().encode().unwrap();
    let mut manifest = Manifest::from_bytes(&files[MANIFEST_FILE]).unwrap();
    manifest.pieces[0].maps.insert("velocity".into(), "tube.velocity.exr".into());
    files.insert(MANIFEST_FILE.into(), manifest.to_bytes().unwrap());
    assert_eq!(Bundle::from_files(&files).unwrap().images, sample().images);
}

#[test]
fn a_full_bundle_refuses_another_piece() {
    let mut bundle = Bundle::new("test");
    bundle.add_piece("a", 4096, 4095).unwrap();
    assert!(bundle.add_piece("b", 4096, 4).is_err());
    assert_eq!(bundle.manifest.pieces.len(), 1);
}
