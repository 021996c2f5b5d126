//! Building: outputs, replacement, failure, sameness, batches.

mod common;
use std::fs;

use common::{Place, bytes};

#[test]
fn a_tube_becomes_a_sound_bundle() {
    let place = Place::new();
    let json = place.built("--pin loop:0 --json").json();
    assert_eq!(json["output"], "tube.gim");
    let piece = &json["pieces"][0];
    assert_eq!((&piece["name"], &piece["first_particle"]), (&"tube".into(), &0.into()));
    assert_eq!((piece["surface"]["euler"].as_i64(), piece["surface"]["loops"].as_i64()), (Some(0), Some(2)));
    for count in ["particles", "pinned", "springs", "seam_points"] {
        assert!(piece["counts"][count].as_u64().unwrap() > 0, "{count}: {piece}");
    }
    assert_eq!(json["seam_gap"], 0.0);
    assert!(json["quality"]["psnr"].as_f64().unwrap() > 20.0, "{}", json["quality"]);
    assert!(json["stages"].as_array().unwrap().len() > 5 && json["seconds"].as_f64().unwrap() > 0.0);
    assert_eq!(json["options"]["pin"][0], "loop:0");
    for map in piece["maps"].as_array().unwrap() {
        let length = fs::metadata(place.path("tube.gim").join(map["file"].as_str().unwrap())).unwrap().len();
        assert_eq!(map["bytes"], length);
    }
    let run = place.run("validate tube.gim").expect(&[0]);
    assert!(run.stdout.is_empty() && run.stderr.contains("sound"), "{}", run.stderr);
}

#[test]
fn an_existing_output_is_replaced_only_with_force() {
    let place = Place::new();
    place.built("");
    let before = bytes(&place.path("tube.gim"));
    let run = place.run("build tube.obj -o tube.gim --texels 200").expect(&[2]);
    assert!(run.stderr.contains("--force") && run.stderr.contains("tube.gim"), "{}", run.stderr);
    assert_eq!(bytes(&place.path("tube.gim")), before);
    place.run("build tube.obj -o tube.gim --texels 200 --force").expect(&[0, 1]);
    assert_ne!(bytes(&place.path("tube.gim")), before);
    // Something that is no bundle is never replaced.
    fs::create_dir(place.path("mine")).unwrap();
    place.write("mine/notes.txt", "mine");
    for output in ["mine", "tube.obj", "mine/notes.txt"] {
        place.run(&format!("build tube.obj -o {output} --force")).expect(&[2]);
    }
    assert_eq!(fs::read_to_string(place.path("mine/notes.txt")).unwrap(), "mine");
}

#[test]
fn a_failing_build_leaves_nothing_behind() {
    let place = Place::new();
    place.write("bad.obj", "v 0 0 0\nv 1 0 0\nv 0 1 0\nf 1 2 9\n");
    place.write("empty.obj", "");
    let before = place.list();
    for args in [
        "bad.obj -o bad.gim --timings",
        "empty.obj -o empty.gim --json",
        "tube.obj -o no/such/directory/tube.gim",
        "tube.obj -o tube.gim --piece nobody --timings",
        "bad.obj empty.obj -o both",
    ] {
        let run = place.run(&format!("build {args}"));
        assert_eq!(run.code, 2, "{args}: {}", run.stderr);
        assert!(run.stderr.contains("error: "), "{args}");
        assert!(run.stderr.contains(args.split_whitespace().next().unwrap()) || args.contains("no/such"), "{args}");
        assert_eq!(place.list(), before, "{args}");
    }
}

#[test]
fn the_same_input_gives_the_same_bytes() {
    let place = Place::new();
    place.built("--pin above:0.7 --timings");
    let first = bytes(&place.path("tube.gim"));
    for flags in ["", "--threads 1", "--threads 2 --json"] {
        place.built(&format!("--pin above:0.7 --force {flags}"));
        assert_eq!(bytes(&place.path("tube.gim")), first, "{flags}");
    }
}

#[test]
fn times_lie_beside_the_bundle_and_are_shown_for_it_alone() {
    let place = Place::new();
    place.built("--timings");
    assert!(place.list().contains(&"tube.timings.json".to_owned()));
    assert!(!bytes(&place.path("tube.gim")).iter().any(|(name, _)| name.contains("timings")));
    let times = &place.run("inspect tube.gim --json").expect(&[0]).json()["timings"];
    assert!(times["seconds"].as_f64().unwrap() > 0.0 && times["stages"][0]["stage"] == "import", "{times}");
    assert!(place.run("inspect tube.gim").stdout.contains("Times"));
    // Another bundle under the same name does not take them over.
    place.run("build tube.obj -o tube.gim --texels 200 --force").expect(&[0, 1]);
    assert!(!place.run("inspect tube.gim").stdout.contains("Times"));
    // Old times are replaced, a file of another kind is not.
    place.built("--timings --force");
    place.write("tube.timings.json", "{}");
    let run = place.run("build tube.obj -o tube.gim --timings --force").expect(&[2]);
    assert!(run.stderr.contains("tube.timings.json"), "{}", run.stderr);
}

#[test]
fn a_batch_with_a_bad_file_fails_but_goes_on() {
    let place = Place::new();
    place.write("bad.obj", "v 0 0 0\nf 1 1 1 oops\n");
    fs::copy(place.path("tube.obj"), place.path("last.obj")).unwrap();
    let run = place.run("build tube.obj bad.obj last.obj -o out --texels 400").expect(&[2]);
    assert_eq!(common::list(&place.path("out")), ["last.gim", "tube.gim"]);
    assert!(run.stderr.contains("1 of 3 inputs failed: bad.obj"), "{}", run.stderr);
    assert!(run.stdout.contains("tube.gim") && run.stdout.contains("last.gim") && !run.stdout.contains("error"));

    let json = place.run("build tube.obj bad.obj -o again --texels 400 --json").expect(&[2]).json();
    assert_eq!((&json["exit"], &json["builds"][1]["exit"]), (&2.into(), &2.into()));
    assert!(json["builds"][1]["error"].as_str().unwrap().contains("bad.obj"), "{json}");
    assert_eq!(json["builds"][0]["pieces"][0]["name"], "tube");

    let run = place.run("build tube.obj tube.obj -o twice").expect(&[2]);
    assert!(run.stderr.contains("both") && !place.path("twice").exists(), "{}", run.stderr);
    place.run("build tube.obj last.obj -o out/tube.gim").expect(&[2]);
}
