//! `gimage simulate`.

mod common;

use common::Place;

#[test]
fn frames_are_dumped_timed_and_the_same_for_any_threads() {
    let place = Place::new();
    let flags = "--backend cpu --n 9 --frames 5 --every 2 --dump-from 1 --json";
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
    let run = place.run("simulate tube.gim --frames 2 --backend cpu").expect(&[0]);
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
        ("simulate s1 --material silk=1", "none of warp"),
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
    assert!(few.stderr.contains("warning: 1 substeps") && few.stderr.contains("2 are made"), "{}", few.stderr);
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
    let flags = "--backend cpu --solver xpbd --tethers 0 --n 16 --frames 240";
    let json = place.run(&format!("simulate s1 {flags} --error 0.02 --json")).expect(&[0]).json();
    let count = |name: &str| json[name].as_u64().unwrap();
    assert!(count("substeps_min") <= count("substeps_median") && count("substeps_median") < count("substeps_max"));
    assert!(json["error_estimated"].as_f64().is_some_and(|e| e < 0.1), "{json}");
    assert_eq!((json["error_target"].as_f64(), json["budget_ms"].as_f64()), (Some(0.02), None));
    // Nothing can be done in so little time, and the budget wins.
    let json = place.run(&format!("simulate s1 {flags} --error 0.02 --budget 1e-9 --json")).expect(&[0]).json();
    assert_eq!((json["substeps"].as_u64(), json["substeps_median"].as_u64()), (Some(1), Some(1)));
    let json = place.run(&format!("simulate s1 {flags} --json")).expect(&[0]).json();
    assert_eq!((json["substeps_min"].as_u64(), json["substeps_max"].as_u64()), (Some(8), Some(8)));
    assert!(json["error_estimated"].is_null());
    let words = place.run(&format!("simulate s1 {flags} --error 0.02")).expect(&[0]).stdout;
    assert!(words.contains("substeps chosen") && words.contains("strain"), "{words}");
}
