//! `--animation` and `--character`: cloth and colliders that follow a character.

use std::path::Path;

use crate::common::Place;

/// A place with the sleeve of the assets, and a bundle of it that is pinned at both ends.
fn place() -> Place {
    let place = Place::new();
    let assets = Path::new(env!("CARGO_MANIFEST_DIR")).join("../../assets");
    std::fs::copy(assets.join("sleeve.glb"), place.path("sleeve.glb")).unwrap();
    let pins = "--pin box:0.1,1,-1,0.205,2,1 --pin box:0.695,1,-1,0.8,2,1";
    place.run(&format!("build sleeve.glb -o sleeve.gim --texels 600 {pins}")).expect(&[0, 1]);
    place
}

fn shaders(json: &serde_json::Value) -> Vec<&str> {
    json["plan"].as_array().unwrap().iter().filter_map(|p| p["shader"].as_str()).collect()
}

#[test]
fn an_animation_moves_the_cloth_of_its_file() {
    let place = place();
    let run = |more: &str| place.run(&format!("simulate sleeve.gim --backend cpu --json {more}")).expect(&[0]).json();
    let moving = run("--animation swing --frames 30");
    assert_eq!(moving["frames"].as_u64(), Some(30));
    assert!(shaders(&moving).contains(&"follow"));
    assert!(!shaders(&run("--frames 2")).contains(&"follow"), "a skin alone costs nothing");
    // An animation that does not end in its first pose plays once.
    let once = place.run("simulate sleeve.gim --backend cpu --animation pull").expect(&[0, 1]);
    assert!(once.stdout.contains("60 frames") && once.stderr.contains("plays once"), "{}{}", once.stdout, once.stderr);
    place.run("render sleeve.gim --backend cpu --animation swing --time 0.5 --size 64x48 -o s.gif").expect(&[0]);
    assert!(place.path("s.gif").is_file());
}

#[test]
fn options_of_an_animation_are_refused_without_one() {
    let place = Place::new();
    for given in ["--lead 0.5", "--character sleeve.glb", "--local shoulder"] {
        let refused = place.run(&format!("simulate s1 --n 9 --frames 1 --backend cpu {given}")).expect(&[2]);
        let option = given.split(' ').next().unwrap();
        assert!(refused.stderr.contains(&format!("{option} needs --animation NAME")), "{}", refused.stderr);
    }
}

#[test]
fn a_collider_moves_with_a_joint() {
    let place = place();
    let scene = |collider: &str, more: &str| {
        place.write(
            "scene.json",
            &format!(
                r#"{{"format": "gimage-scene", "version": 1, "duration": 0.5,
                    "character": {{"file": "sleeve.glb", "animation": "swing"}},
                    "cloths": [{{"from": {{"bundle": "sleeve.gim"}}{more}}}],
                    "colliders": [{{"shape": {{"capsule": {{"half_height": 0.1, "radius": 0.05}}}}, "position": [0.32, 1.4, 0],
                                    "rotation": {{"axis": [0, 0, 1], "degrees": 90}}, {collider}}}]}}"#
            ),
        );
        place.run("simulate scene.json --backend cpu --json")
    };
    let run = scene(r#""joint": "shoulder""#, "").expect(&[0, 1]).json();
    assert!(shaders(&run).contains(&"follow") && shaders(&run).contains(&"contact"));
    // The upper arm inside of the sleeve goes with it: without its joint it would stay, and the sleeve would be pulled over it.
    let depth = |json: &serde_json::Value| json["cloths"][0]["contact_depth_m"].as_f64().unwrap();
    assert!(depth(&run) < 1e-3, "{}", depth(&run));
    for (collider, more, words) in [
        (r#""joint": "hand""#, "", "`hand`"),
        (r#""joint": "elbow", "motion": [{"time": 0, "position": [0, 0, 0]}]"#, "", "colliders[0].joint"),
        (r#""friction": 0"#, r#", "position": [0, 1, 0]"#, "cloths[0]"),
    ] {
        let run = scene(collider, more).expect(&[2]);
        assert!(run.stderr.contains(words), "{words}: {}", run.stderr);
    }
}

#[test]
fn a_character_is_simulated_in_the_frame_of_a_joint() {
    let place = place();
    let run = |more: &str| {
        let args = format!("simulate sleeve.gim --backend cpu --json --animation swing --frames 60 --lead 0 {more}");
        place.run(&args).expect(&[0]).json()["cloths"][0]["stretch_max"].as_f64().unwrap()
    };
    let [world, local, calm] = [run(""), run("--local shoulder"), run("--local elbow --inertia 0,0.5,0")];
    assert!([world, local, calm].iter().all(|s| *s < 0.3), "{world} {local} {calm}");
    let scene = r#"{"format": "gimage-scene", "version": 1, "duration": 0.5, "cloths": [{"from": {"bundle": "sleeve.gim"}}],
                    "character": {"file": "sleeve.glb", "animation": "swing"},
                    "colliders": [{"shape": "half_space", "position": [0, 0, 0], "motion": [{"time": 0, "position": [0, 0, 0]}]}]}"#;
    place.write("scripted.json", scene);
    for (args, words) in [
        ("sleeve.gim --local shoulder", "--animation"),
        ("sleeve.gim --animation swing --local hips", "`hips`"),
        ("sleeve.gim --animation swing --local elbow --inertia 2", "from 0 to 1"),
        ("scripted.json --local elbow", "script"),
    ] {
        let run = place.run(&format!("simulate {args} --backend cpu")).expect(&[2]);
        assert!(run.stderr.contains(words), "{words}: {}", run.stderr);
    }
}

#[test]
fn what_cannot_be_played_is_said() {
    let place = place();
    for (args, words) in [
        ("simulate sleeve.gim --animation run", "\"swing\", \"pull\""),
        ("simulate sleeve.gim --character sleeve.glb", "--animation"),
        ("simulate sleeve.gim --animation swing --solver classic", "xpbd"),
        ("simulate sleeve.gim --animation swing --character tube.obj", "tube.obj"),
        ("simulate s1 --animation swing --character sleeve.glb", "nothing of the scene follows"),
    ] {
        let run = place.run(&format!("{args} --backend cpu")).expect(&[2]);
        assert!(run.stderr.contains(words), "{words}: {}", run.stderr);
    }
    // The bundle has all of the file, unless it was built without the mesh.
    place.run("build sleeve.glb -o bare.gim --texels 600 --pin loop:0 --render-mesh off").expect(&[0, 1]);
    std::fs::remove_file(place.path("sleeve.glb")).unwrap();
    place.run("simulate sleeve.gim --animation swing --backend cpu --frames 2").expect(&[0, 1]);
    let run = place.run("simulate bare.gim --animation swing --backend cpu").expect(&[2]);
    assert!(run.stderr.contains("--character FILE"), "{}", run.stderr);
}

#[test]
fn a_dressed_character_has_colliders_that_move_with_its_joints() {
    let place = place();
    // The file has no body: the sleeve is built, with a warning.
    let bare = place.run("dress sleeve.glb -o bare.gim --texels 600").expect(&[1]);
    assert!(bare.stderr.contains("no-body") && bare.stderr.contains("hint-pins"), "{}", bare.stderr);
    assert!(!std::fs::read_to_string(place.path("bare.gim/manifest.json")).unwrap().contains("\"colliders\""));
    // Here its own surface stands for the body.
    let fitted = place.run("fit-colliders sleeve.glb --body * -o body.json --json").expect(&[0, 1]).json();
    let colliders = fitted["colliders"].as_array().unwrap();
    assert!(!colliders.is_empty() && colliders.iter().all(|c| c["joint"].is_string()), "{fitted}");
    assert!(fitted["error"]["p95"].as_f64().unwrap() < 0.03, "{fitted}");
    let scene: serde_json::Value =
        serde_json::from_str(&std::fs::read_to_string(place.path("body.json")).unwrap()).unwrap();
    assert_eq!(scene["colliders"].as_array().unwrap().len(), colliders.len());
    // A bundle with these in its manifest.
    place.run("dress sleeve.glb -o arm.gim --texels 600 --pin loop:0").expect(&[1]);
    let mut manifest: serde_json::Value =
        serde_json::from_str(&std::fs::read_to_string(place.path("arm.gim/manifest.json")).unwrap()).unwrap();
    manifest["colliders"] = serde_json::json!([{"joint": "shoulder", "shape": {"capsule": {"half_height": 0.1, "radius": 0.05}},
        "position": [0.32, 1.4, 0], "rotation": [0, 0, 0.5f64.sqrt(), 0.5f64.sqrt()]}]);
    place.write("arm.gim/manifest.json", &manifest.to_string());
    place.run("validate arm.gim").expect(&[0]);
    let run = place.run("simulate arm.gim --backend cpu --json --animation swing --frames 30").expect(&[0, 1]).json();
    assert!(shaders(&run).contains(&"contact") && shaders(&run).contains(&"follow"), "{run}");
}
