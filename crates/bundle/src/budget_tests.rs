use std::collections::BTreeMap;

use super::*;
use crate::bundle::tests::sample;
use crate::manifest::{PieceEntry, Repair};
use crate::{Bundle, Image, encode_exr};

/// A manifest with `count` copies of `item` in a list.
fn with_list(name: &str, item: &str, count: usize) -> Vec<u8> {
    let items = [item].repeat(count).join(",");
    let head = r#""format":"gimage-bundle","version":1,"generator":"","units":"metre","pieces":[]"#;
    format!(r#"{{{head},"{name}":[{items}]}}"#).into_bytes()
}

#[test]
fn a_manifest_of_many_empty_records_is_refused_unread() {
    // 60 MB, which took 4 to 6 GB and ended the process.
    for (name, limit) in [("repairs", MAX_REPAIRS), ("accessories", MAX_ACCESSORIES), ("colliders", MAX_COLLIDERS)] {
        let error = Manifest::from_bytes(&with_list(name, "{}", 20_000_000)).unwrap_err().to_string();
        assert!(error.contains(name) && error.contains(&limit.to_string()), "{error}");
    }
    // The last one that is allowed, and one more.
    let limit = MAX_REPAIRS as usize;
    assert_eq!(Manifest::from_bytes(&with_list("repairs", "{}", limit)).unwrap().repairs.len(), limit);
    assert!(Manifest::from_bytes(&with_list("repairs", "{}", limit + 1)).is_err());
}

#[test]
fn values_anywhere_in_a_manifest_are_counted() {
    for item in ["{}", r#"{"":0}"#, "[]", "0"] {
        let count = (60 << 20) / (item.len() + 1);
        for name in ["options", "files", "unknown", "quality"] {
            let error = Manifest::from_bytes(&with_list(name, item, count)).unwrap_err().to_string();
            assert!(error.contains("manifest.json") && error.contains("at most"), "{error}");
        }
    }
    let nested = format!(r#"{{"format":{}0{}}}"#, "[".repeat(100_000), "]".repeat(100_000));
    assert!(Manifest::from_bytes(nested.as_bytes()).is_err());
}

#[test]
fn lists_that_cannot_be_read_back_are_not_written() {
    let mut bundle = sample();
    bundle.manifest.repairs = vec![Repair::default(); MAX_REPAIRS as usize + 1];
    let error = bundle.encode().unwrap_err().to_string();
    assert!(error.contains("`repairs`") && error.contains(&MAX_REPAIRS.to_string()), "{error}");
}

/// A bundle whose one piece has `count` custom maps of one image.
fn many_maps(image: &Image, count: usize) -> BTreeMap<String, Vec<u8>> {
    let mut bundle = Bundle::new("test");
    bundle.manifest.pieces =
        vec![PieceEntry { name: "p".into(), width: image.width, height: image.height, ..Default::default() }];
    let mut maps: BTreeMap<String, String> = (0..count).map(|k| (format!("_M{k}"), format!("p.{k}.exr"))).collect();
    maps.insert("position".into(), "p.position.exr".into());
    bundle.manifest.pieces[0].maps = maps.clone();
    let bytes = encode_exr(image).unwrap();
    let mut files: BTreeMap<_, _> = maps.into_values().map(|file| (file, bytes.clone())).collect();
    files.insert("manifest.json".into(), bundle.manifest.to_bytes().unwrap());
    files
}

#[test]
fn many_zero_maps_are_refused_before_any_is_decoded() {
    // 15.8 MB on the disk, 16 GB in memory.
    let image = Image::zeros(16_384, 1023, 4);
    let files = many_maps(&image, 60);
    assert!(files.values().map(Vec::len).sum::<usize>() < 20_000_000);
    drop(image);
    for error in [Bundle::from_files(&files).err(), Bundle::decode_lenient(|n, _| Ok(files[n].clone())).err()] {
        let error = error.unwrap().to_string();
        assert!(error.contains("16362897408") || error.contains(&(61_u64 * 16_384 * 1023 * 16).to_string()), "{error}");
        assert!(error.contains(&MAX_IMAGE_BYTES.to_string()), "{error}");
    }
}

#[test]
fn the_channels_of_a_header_count_not_the_most_there_could_be() {
    // 64 maps of one channel are within the limit where as many of four are not: 2^24 texels and less for a quick test.
    let image = Image::zeros(2048, 1024, 1);
    let mut files = many_maps(&image, 200);
    files.insert("p.position.exr".into(), encode_exr(&Image::zeros(2048, 1024, 4)).unwrap());
    let manifest = Manifest::from_bytes(&files["manifest.json"]).unwrap();
    let check = |files: &BTreeMap<String, Vec<u8>>| {
        check_images(&manifest, &mut |name: &str, _| Ok(files[name].clone()), |_, _| u64::MAX)
    };
    check(&files).unwrap();
    let four = encode_exr(&Image::zeros(2048, 1024, 4)).unwrap();
    files.iter_mut().filter(|(name, _)| name.ends_with(".exr")).for_each(|(_, bytes)| bytes.clone_from(&four));
    assert!(matches!(check(&files), Err(Error::TooLarge { .. })));
}
