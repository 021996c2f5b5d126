//! Inspecting, validating and reconstructing a bundle.

use std::fs;

use crate::common::Place;

#[test]
fn inspect_says_the_same_in_words_and_in_json() {
    let place = Place::new();
    let built = place.built("--json").json();
    let json = place.run("inspect tube.gim --json").expect(&[0]).json();
    for field in ["pieces", "quality", "options", "source", "repairs", "accessories", "texels", "seam_gap"] {
        assert_eq!(json[field], built[field], "{field}");
    }
    let text = place.run("inspect tube.gim").expect(&[0]).stdout;
    for word in ["tube.position.exr", "PSNR", "Hausdorff", "seam points", "stretch", "flips", "sha256", "seams"] {
        assert!(text.contains(word), "{word}: {text}");
    }
    let piece = &json["pieces"][0];
    assert!(text.contains(&format!("{} x {}", piece["width"], piece["height"])), "{text}");
    assert!(text.lines().all(|line| line == line.trim_end()), "{text}");
}

#[test]
fn a_manifest_that_lies_is_found_out() {
    let place = Place::new();
    place.built("");
    let path = place.path("tube.gim/manifest.json");
    let mut manifest: serde_json::Value = serde_json::from_slice(&fs::read(&path).unwrap()).unwrap();
    manifest["pieces"][0]["counts"]["pinned"] = 7.into();
    fs::write(&path, manifest.to_string()).unwrap();
    let run = place.run("inspect tube.gim").expect(&[1]);
    assert!(run.stderr.contains("says 7 pinned, the images have 0"), "{}", run.stderr);
    let json = place.run("validate tube.gim --json").expect(&[1]).json();
    assert_eq!(
        (&json["exit"], &json["sound"], &json["faults"][0]["kind"]),
        (&1.into(), &false.into(), &"count".into())
    );
    let run = place.run("validate tube.gim").expect(&[1]);
    assert!(run.stdout.starts_with("manifest.json: piece tube: "), "{}", run.stdout);
}

#[test]
fn damage_is_unreadable() {
    let place = Place::new();
    place.built("");
    fs::write(place.path("tube.gim/tube.position.exr"), "no image").unwrap();
    let run = place.run("validate tube.gim").expect(&[2]);
    assert!(run.stdout.starts_with("tube.position.exr: "), "{}", run.stdout);
    assert_eq!(run.stdout.matches("tube.position.exr").count(), run.stdout.lines().count(), "{}", run.stdout);
    for args in ["inspect tube.gim", "reconstruct tube.gim -o a.obj"] {
        let run = place.run(args).expect(&[2]);
        assert!(run.stdout.is_empty() && run.stderr.contains("tube.position.exr"), "{}", run.stderr);
    }
    fs::write(place.path("tube.gim/manifest.json"), "{}").unwrap();
    let json = place.run("validate tube.gim --json").expect(&[2]).json();
    assert!(json["error"].as_str().unwrap().contains("tube.gim"), "{json}");
    assert!(!place.path("a.obj").exists());
}

#[test]
fn a_name_cannot_steer_the_terminal() {
    let place = Place::new();
    place.built("");
    let path = place.path("tube.gim/manifest.json");
    let text = fs::read_to_string(&path).unwrap().replace("\"name\": \"tube\"", "\"name\": \"\\u001b[2Jtube\"");
    fs::write(&path, text).unwrap();
    for args in ["inspect tube.gim", "validate tube.gim"] {
        let run = place.run(args).expect(&[0]);
        assert!(!run.stdout.contains('\x1b') && !run.stderr.contains('\x1b'), "{args}");
    }
}

#[test]
fn the_surface_comes_back_with_its_texture_coordinates() {
    let place = Place::new();
    place.built("");
    let run = place.run("reconstruct tube.gim -o back.obj").expect(&[0]);
    assert!(run.stdout.is_empty() && run.stderr.contains("back.obj"));
    let text = fs::read_to_string(place.path("back.obj")).unwrap();
    for start in ["v ", "vn ", "vt ", "o tube", "f "] {
        assert!(text.lines().any(|line| line.starts_with(start)), "{start}");
    }
    place.run("reconstruct tube.gim -o back.GLB").expect(&[0]);
    assert!(fs::read(place.path("back.GLB")).unwrap().starts_with(b"glTF"));

    place.write("back.obj", "mine");
    let run = place.run("reconstruct tube.gim -o back.obj").expect(&[2]);
    assert!(run.stderr.contains("--force"), "{}", run.stderr);
    assert_eq!(fs::read_to_string(place.path("back.obj")).unwrap(), "mine");
    place.run("reconstruct tube.gim -o back.obj --force").expect(&[0]);
    assert_eq!(fs::read_to_string(place.path("back.obj")).unwrap(), text);
    // Both kinds of mesh build again, to a surface of the same kind.
    for mesh in ["back.obj", "back.GLB"] {
        let json = place.run(&format!("build {mesh} -o again.gim --texels 600 --force --json")).expect(&[0, 1]).json();
        assert_eq!(json["pieces"][0]["surface"]["loops"], 2, "{mesh}");
    }
    assert!(place.list().iter().all(|name| !name.starts_with('.')));
}

#[test]
fn a_mesh_of_nothing_or_of_no_numbers_is_not_written() {
    let place = Place::new();
    place.built("");
    let bundle = place.path("tube.gim");
    let mut read = gimage_bundle::dir::read_dir(&bundle).unwrap();
    let uv = (0, gimage_bundle::MapKind::Uv(0));
    read.images.get_mut(&uv).unwrap().data[0] = f32::NAN;
    gimage_bundle::dir::write_dir(&read, &bundle, true).unwrap();
    for mesh in ["a.obj", "a.glb"] {
        let run = place.run(&format!("reconstruct tube.gim -o {mesh}")).expect(&[2]);
        assert!(run.stderr.contains("tube.gim") && run.stderr.contains("texel (0, 0)"), "{}", run.stderr);
    }
    // Without particles there is no triangle.
    read.images.remove(&uv);
    let (width, height) = (read.manifest.pieces[0].width, read.manifest.pieces[0].height);
    let empty = gimage_bundle::Image::zeros(width, height, 4);
    read.images.insert((0, gimage_bundle::MapKind::Position), empty);
    gimage_bundle::dir::write_dir(&read, &bundle, true).unwrap();
    let run = place.run("reconstruct tube.gim -o a.obj").expect(&[2]);
    assert!(run.stderr.contains("there is no triangle in it"), "{}", run.stderr);
    assert_eq!(place.list(), ["tube.gim", "tube.obj"]);
}

#[test]
fn a_bundle_that_decodes_to_too_much_memory_is_refused() {
    let place = Place::new();
    place.built("");
    let path = place.path("tube.gim/manifest.json");
    let text = fs::read_to_string(&path).unwrap();
    let mut manifest: serde_json::Value = serde_json::from_str(&text).unwrap();
    manifest["repairs"] = vec![serde_json::json!({}); 100_000].into();
    fs::write(&path, manifest.to_string()).unwrap();
    for command in ["inspect", "validate"] {
        let run = place.run(&format!("{command} tube.gim")).expect(&[2]);
        assert!(run.stderr.contains("`repairs`") && run.stderr.contains("65536"), "{}", run.stderr);
    }
}

#[test]
fn inspect_shows_the_box_that_pins_are_about() {
    let place = Place::new();
    place.built("");
    let bounds = &place.run("inspect tube.gim --json").expect(&[0]).json()["pieces"][0]["bounds"];
    let near = |end: &str, k: usize, x: f64| (bounds[end][k].as_f64().unwrap() - x).abs() < 0.01;
    assert!(near("min", 1, 0.0) && near("max", 1, 0.8) && near("min", 0, -0.3) && near("max", 2, 0.3), "{bounds}");
    let text = place.run("inspect tube.gim").expect(&[0]).stdout;
    assert!(text.contains("Bounding box") && text.contains(" to 0.8000 m"), "{text}");
}
