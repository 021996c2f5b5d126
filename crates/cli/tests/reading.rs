//! Inspecting, validating and reconstructing a bundle.

mod common;
use std::fs;

use common::Place;

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
