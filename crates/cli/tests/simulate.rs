//! `gimage simulate`.

use crate::common::{self, Place};

#[test]
fn frames_are_dumped_timed_and_the_same_for_any_threads() {
    let place = Place::new();
    let flags = "--backend cpu --n 9 --substeps 8 --frames 5 --every 2 --dump-from 1 --json";
    let run = |threads, dir| place.run(&format!("simulate s1 {flags} --threads {threads} --dump {dir}")).expect(&[0]);
    let json = run(1, "one").json();
    run(2, "two");
    assert_eq!((json["frames"].as_u64(), json["backend"].as_str()), (Some(5), Some("cpu")));
    assert_eq!(json["dispatches_per_frame"].as_u64(), Some(8 * 11 + 3));
    assert!(json["ms_frame_min"].as_f64() <= json["ms_frame_median"].as_f64());
    assert_eq!(json["plan"].as_array().map(Vec::len), Some(14));
    let mut names: Vec<_> = std::fs::read_dir(place.path("one")).unwrap().map(|e| e.unwrap().file_name()).collect();
    names.sort();
    let expected = [1, 3, 5].map(|k| format!("frame_0000{k}.s1.position.exr"));
    assert_eq!(names, expected.map(std::ffi::OsString::from));
    for name in names {
        let bytes = |dir| std::fs::read(place.path(dir).join(&name)).unwrap();
        assert!(bytes("one") == bytes("two"));
    }
}

#[test]
fn a_bundle_falls() {
    let place = Place::new();
    place.run("build tube.obj -o tube.gim --texels 400").expect(&[0, 1]);
    let run = place.run("simulate tube.gim --frames 2 --backend cpu -v").expect(&[0]);
    assert!(run.stdout.contains("2 frames on the cpu") && run.stdout.contains("seams"), "{}", run.stdout);
}

#[test]
fn a_material_is_a_membrane_that_bends() {
    let place = Place::new();
    let flags = "--backend cpu --n 9 --frames 2 --solver xpbd --tethers 0 --json";
    let shaders = |more: &str| {
        let json = place.run(&format!("simulate s1 {flags} {more}")).expect(&[0]).json();
        let list = json["plan"].as_array().unwrap().iter().map(|p| p["shader"].as_str().unwrap().to_owned());
        list.collect::<Vec<_>>()
    };
    let made = shaders("--material warp=300,bend=1e-4");
    assert!(["membrane", "moments", "bend"].iter().all(|s| made.iter().any(|m| m == s)), "{made:?}");
    assert!(shaders("").iter().all(|s| s != "membrane") && made.iter().all(|s| s != "stretch"));
    assert!(shaders("--material bend=0").iter().all(|s| s != "bend"));
}

#[test]
fn what_cannot_be_is_said() {
    let place = Place::new();
    for (args, words) in [
        ("simulate s9", "s2f"),
        ("simulate s1 --substeps 0", "substeps"),
        ("simulate s1 --backend cpu --error 2", "stretch"),
        ("simulate s1 --backend cpu --budget 0", "budget"),
        ("simulate s1 --n 1", "--n"),
        ("simulate tube.obj", "tube.obj"),
        ("simulate s1 --every 2", "--dump"),
        ("simulate s1 --material warp", "NAME=NUMBER"),
        ("simulate s1 --material silk=1", "not one of warp"),
        ("simulate s1 --material bend=soft", "not a number"),
        ("simulate s1 --material density=0", "density"),
        ("simulate s1 --material thickness=2", "thickness"),
        ("simulate s1 --material friction=-1", "friction"),
    ] {
        let run = place.run(args).expect(&[2]);
        assert!(run.stderr.contains(words), "{args}: {}", run.stderr);
    }
}

#[test]
fn what_the_solver_cannot_do_is_changed_and_said() {
    let place = Place::new();
    let run = |more: &str| place.run(&format!("simulate s1 --backend cpu --n 9 --frames 2 --json {more}")).expect(&[0]);
    let few = run("--solver xpbd --tethers 0 --substeps 1");
    assert!(few.stderr.contains("warning: 1 substeps") && few.stderr.contains("2 are used"), "{}", few.stderr);
    let json = few.json();
    let said = json["warnings"].as_array().map(Vec::len);
    assert_eq!((json["substeps"].as_u64(), said), (Some(2), Some(1)));
    for enough in ["--solver xpbd --substeps 1", "--substeps 1"] {
        let run = run(enough);
        assert_eq!((run.json()["warnings"].as_array().map(Vec::len), run.stderr.as_str()), (Some(0), ""));
    }
}

#[test]
fn substeps_are_chosen_and_reported() {
    let place = Place::new();
    let flags = "--backend cpu --solver xpbd --tethers 0 --substeps 8 --n 16 --frames 240";
    let json = place.run(&format!("simulate s1 {flags} --error 0.02 --json")).expect(&[0]).json();
    let count = |name: &str| json[name].as_u64().unwrap();
    assert!(count("substeps_min") <= count("substeps_median") && count("substeps_median") < count("substeps_max"));
    assert!(json["error_estimated"].as_f64().is_some_and(|e| e < 0.1), "{json}");
    assert_eq!((json["error_target"].as_f64(), json["budget_ms"].as_f64()), (Some(0.02), None));
    // Nothing can be done in so little time, and the budget wins: the cloth is like rubber, which is a finding.
    let json = place.run(&format!("simulate s1 {flags} --error 0.02 --budget 1e-9 --json")).expect(&[1]).json();
    assert_eq!((json["substeps"].as_u64(), json["substeps_median"].as_u64()), (Some(1), Some(1)));
    let json = place.run(&format!("simulate s1 {flags} --json")).expect(&[0]).json();
    assert_eq!((json["substeps_min"].as_u64(), json["substeps_max"].as_u64()), (Some(8), Some(8)));
    assert!(json["error_estimated"].is_null());
    let words = place.run(&format!("simulate s1 {flags} --error 0.02 -v")).expect(&[0]).stdout;
    assert!(words.contains("substeps chosen") && words.contains("rounds of polish: least"), "{words}");
    assert!(words.contains("strain"), "{words}");
    let rounds = |more: &str| {
        let flags = "--backend cpu --frames 300 --error 0.05 --json";
        let json = place.run(&format!("simulate s1 {flags} {more}")).expect(&[0]).json();
        ["polish_min", "polish", "polish_max"].map(|name| json[name].as_u64().unwrap())
    };
    let [least, _, most] = rounds("");
    assert!(least < most, "{least} {most}");
    assert_eq!(rounds("--polish 3"), [3; 3]);
}

#[test]
fn without_flags_the_scene_decides_and_the_table_says_how_the_cloth_fares() {
    let place = Place::new();
    let run = place.run("simulate s2 --n 16 --backend cpu --frames 30").expect(&[0]);
    for words in
        ["substeps, 3 rounds of polish: chosen, as cloth 's2' falls on colliders", "stretch mean", "worst p99", "mm/s"]
    {
        assert!(run.stdout.contains(words), "{words}: {}", run.stdout);
    }
    assert!(!run.stdout.contains("dispatches"), "{}", run.stdout);
    let run = place.run("simulate s2 --n 16 --backend cpu --frames 30 --substeps 5 --json").expect(&[0]);
    let json = run.json();
    assert_eq!((json["substeps"].as_u64(), json["polish"].as_u64()), (Some(5), Some(0)));
    assert!(json["cloths"][0]["stretch_p99"].is_f64() && json["findings"].as_array().is_some_and(Vec::is_empty));
}

#[test]
fn cloth_that_tunnels_and_falls_is_a_finding() {
    let place = Place::new();
    let run = place.run("simulate s2f --n 64 --backend cpu --substeps 8 --json").expect(&[1]);
    let kinds: Vec<_> = run.json()["findings"].as_array().unwrap().iter().map(|f| f["kind"].clone()).collect();
    assert!(kinds.contains(&"tunnelled".into()) && kinds.contains(&"stretched".into()), "{kinds:?}");
    assert!(
        run.stderr.contains("went through collider 0") && run.stderr.contains("substeps (now 8)"),
        "{}",
        run.stderr
    );
    let run = place.run("simulate s2f --n 64 --backend cpu --json").expect(&[0]);
    assert_eq!(run.json()["findings"].as_array().map(Vec::len), Some(0));
    overflowing(&place, "-9.81");
    let run = place.run("simulate storm.json --backend cpu --frames 90").expect(&[1]);
    assert!(run.stderr.contains("it falls, as no pin holds it"), "{}", run.stderr);
}

#[test]
fn a_pyramid_on_cloth_that_meets_colliders_is_warned_of() {
    let place = Place::new();
    let run =
        |more: &str| place.run(&format!("simulate s2 --n 16 --backend cpu --frames 2 {more}")).expect(&[0]).stderr;
    assert!(run("--pyramid 2").contains("the pyramid is not used"));
    assert_eq!(run(""), "");
}

/// A flag whose gravity is more than numbers hold.
fn overflowing(place: &Place, gravity: &str) {
    let cloth =
        r#"{"from": {"flat": {"width": 9, "height": 9, "right": [1, 0, 0], "down": [0, 0, 1]}}, "name": "flag"}"#;
    let text =
        format!(r#"{{"format": "gimage-scene", "version": 1, "gravity": [0, {gravity}, 0], "cloths": [{cloth}]}}"#);
    place.write("storm.json", &text);
}

#[test]
fn an_overflow_that_holds_the_cloth_still_is_a_finding() {
    let place = Place::new();
    overflowing(&place, "-1e20");
    let flags = "storm.json --backend cpu --frames 5";
    let run = place.run(&format!("simulate {flags} --json")).expect(&[1]);
    assert!(
        run.stderr.contains("'flag': 5 of 5 frames overflowed") && run.stderr.contains("--substeps"),
        "{}",
        run.stderr
    );
    let json = run.json();
    assert_eq!((json["exit"].as_u64(), json["faults"][0]["frames_taken_back"].as_u64()), (Some(1), Some(5)));
    overflowing(&place, "-9.81");
    let json = place.run(&format!("simulate {flags} --json")).expect(&[0]).json();
    assert_eq!(json["faults"].as_array().map(Vec::len), Some(0));
}

#[test]
fn nan_of_the_classic_solver_is_a_finding() {
    let place = Place::new();
    overflowing(&place, "-1e38");
    let run = place.run("simulate storm.json --backend cpu --solver classic --frames 5 --json").expect(&[1]);
    assert!(run.stderr.contains("not finite") && run.stderr.contains("--solver xpbd"), "{}", run.stderr);
    assert!(run.json()["faults"][0]["positions_not_finite"].as_u64().is_some_and(|n| n > 0));
}

#[test]
fn frames_of_an_older_run_are_refused_or_removed() {
    let place = Place::new();
    let run = |more: &str| place.run(&format!("simulate s1 --backend cpu --n 9 --dump out {more}"));
    run("--frames 4").expect(&[0]);
    std::fs::write(place.path("out/mine.exr"), "not a frame").unwrap();
    let refused = run("--frames 2").expect(&[2]);
    assert!(
        refused.stderr.contains("5 frames of an older run") && refused.stderr.contains("--force"),
        "{}",
        refused.stderr
    );
    assert_eq!(common::list(&place.path("out")).len(), 6);
    let forced = run("--frames 2 --force").expect(&[0]);
    assert!(forced.stderr.contains("5 frames of an older run removed"), "{}", forced.stderr);
    let names = common::list(&place.path("out"));
    assert_eq!(names.len(), 4, "{names:?}");
    assert!(names.contains(&"mine.exr".into()) && !names.iter().any(|n| n.starts_with("frame_00004")));
}

/// Files have a limit in size, as on a full disk, that the first frame keeps to or not, and that a later one exceeds.
#[cfg(unix)]
#[test]
fn a_dump_on_a_full_disk_leaves_no_cut_off_frame() {
    let place = Place::new();
    for blocks in [2, 20] {
        let dir = format!("out{blocks}");
        let run = format!("simulate s1 --backend cpu --n 80 --frames 3 --dump {dir}");
        let text = format!("trap '' XFSZ; ulimit -f {blocks}; exec {} {run}", env!("CARGO_BIN_EXE_gimage"));
        let mut shell = std::process::Command::new("sh");
        let out = shell.arg("-c").arg(text).current_dir(place.0.path()).output().unwrap();
        let words = String::from_utf8_lossy(&out.stderr);
        assert_eq!(out.status.code(), Some(2), "{words}");
        let names = common::list(&place.path(&dir));
        assert!(names.iter().all(|n| n.starts_with("frame_") && !words.contains(n.as_str())), "{names:?}: {words}");
        assert!(words.contains(&format!("frame_0000{}.s1.position.exr", names.len())), "{names:?}: {words}");
    }
}

#[test]
fn a_grid_too_large_for_an_image_is_refused_before_stepping() {
    let place = Place::new();
    let cloth =
        r#"{"from": {"flat": {"width": 16385, "height": 2, "right": [1, 0, 0], "down": [0, 0, 1]}}, "name": "ribbon"}"#;
    place.write("long.json", &format!(r#"{{"format": "gimage-scene", "version": 1, "cloths": [{cloth}]}}"#));
    // Stepped, this would take hours.
    let run =
        place.run("simulate long.json --backend cpu --frames 1000000 --dump out --dump-from 1000000").expect(&[2]);
    assert!(run.stderr.contains("16385 x 2") && run.stderr.contains("16384"), "{}", run.stderr);
    assert!(!place.path("out").exists());
}

#[test]
fn a_scene_that_would_throw_its_cloth_out_of_a_floor_is_cleared_unless_it_says_otherwise() {
    let place = Place::new();
    let flags = "--backend cpu --frames 30 --json";
    let scene = |up: f32, more: &str| {
        let flat = r#"{"width": 17, "height": 17, "right": [1, 0, 0], "down": [0, 0, 1]}"#;
        let cloth = format!(r#"{{"from": {{"flat": {flat}}}}}"#);
        let floor = format!(r#"{{"shape": {{"half_space": {{}}}}, "position": [0, {up}, 0]}}"#);
        format!(r#"{{"format": "gimage-scene", "version": 1, {more} "cloths": [{cloth}], "colliders": [{floor}]}}"#)
    };
    place.write("deep.json", &scene(0.05, ""));
    place.write("left.json", &scene(0.05, r#""clear_start": false,"#));
    place.write("shallow.json", &scene(1e-4, ""));
    let run = place.run(&format!("simulate deep.json {flags}")).expect(&[0]);
    assert!(run.stderr.contains("289 of 289 free particles began inside"), "{}", run.stderr);
    let run = place.run(&format!("simulate left.json {flags}")).expect(&[1]);
    assert_eq!(run.json()["findings"][0]["kind"], "thrown");
    let run = place.run(&format!("simulate deep.json {flags} --clear-start off")).expect(&[1]);
    assert_eq!(run.json()["findings"][0]["kind"], "thrown");
    let run = place.run(&format!("simulate shallow.json {flags}")).expect(&[0]);
    assert!(!run.stderr.contains("began inside"), "{}", run.stderr);
}
