//! Building: outputs, replacement, failure, sameness, batches.

use std::fs;

use crate::common::{self, Place, bytes};

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
    // Something that is not a bundle is never replaced.
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

#[test]
fn a_name_of_full_length_is_built_and_a_longer_one_refused_before_the_work() {
    let place = Place::new();
    for length in [243, 255] {
        let name = "n".repeat(length);
        place.run(&format!("build tube.obj -o {name} --texels 400 --no-metrics")).expect(&[0]);
        place.run(&format!("validate {name}")).expect(&[0]);
    }
    // The input is bad too, and is not looked at.
    place.write("bad.obj", "v");
    for args in [format!("-o {}", "n".repeat(256)), format!("-o {}.gim --timings", "n".repeat(245))] {
        let run = place.run(&format!("build bad.obj {args}")).expect(&[2]);
        assert!(!run.stderr.contains("bad.obj") && run.stderr.contains("nnn"), "{}", run.stderr);
    }
    let run = place.run(&format!("reconstruct none.gim -o {}.obj", "n".repeat(252))).expect(&[2]);
    assert!(!run.stderr.contains("none.gim"), "{}", run.stderr);
}

#[test]
#[cfg(target_os = "linux")]
fn a_report_that_cannot_be_written_is_a_failed_build_that_leaves_nothing() {
    let place = Place::new();
    let full = |args: &str| {
        place.run_with(args, |c| {
            c.stdout(fs::OpenOptions::new().write(true).open("/dev/full").unwrap());
        })
    };
    for flags in ["", "--json", "--timings"] {
        let run = full(&format!("build tube.obj -o tube.gim --texels 400 {flags}")).expect(&[2]);
        assert!(run.stderr.contains("stdout: ") && !run.stderr.contains("wrote"), "{}", run.stderr);
        assert_eq!(place.list(), ["tube.obj"], "{flags}");
    }
    // An older bundle stays as it is.
    place.built("");
    let before = bytes(&place.path("tube.gim"));
    full("build tube.obj -o tube.gim --texels 400 --force --json").expect(&[2]);
    assert_eq!(bytes(&place.path("tube.gim")), before);
    // Bundles that were written before a failure stay, and the message states it.
    fs::copy(place.path("tube.obj"), place.path("b.obj")).unwrap();
    let run = full("build tube.obj b.obj -o out --texels 400 --json").expect(&[2]);
    assert!(run.stderr.contains("the bundles were written"), "{}", run.stderr);
    assert_eq!(common::list(&place.path("out")), ["b.gim", "tube.gim"]);
    for args in ["--help", "inspect tube.gim", "--version"] {
        assert!(full(args).expect(&[2]).stderr.contains("stdout: "), "{args}");
    }
}

#[test]
#[cfg(unix)]
fn a_pipe_or_a_device_is_refused_unread() {
    use std::os::unix::fs::symlink;
    let place = Place::new();
    assert!(std::process::Command::new("mkfifo").arg(place.path("pipe.obj")).status().unwrap().success());
    symlink("/dev/zero", place.path("zero.glb")).unwrap();
    symlink("/dev/zero", place.path("zero.bin")).unwrap();
    place.write(
        "beside.gltf",
        r#"{"asset": {"version": "2.0"}, "scenes": [{"nodes": [0]}], "nodes": [{"mesh": 0}], "buffers": [{"uri": "zero.bin",
            "byteLength": 36}], "bufferViews": [{"buffer": 0, "byteLength": 36}], "accessors": [{"bufferView": 0, "count": 3,
            "componentType": 5126, "type": "VEC3"}], "meshes": [{"primitives": [{"attributes": {"POSITION": 0}}]}]}"#,
    );
    for (input, named) in [("pipe.obj", "pipe.obj"), ("zero.glb", "zero.glb"), ("beside.gltf", "zero.bin")] {
        let run = place.run(&format!("build {input} -o a.gim")).expect(&[2]);
        assert!(run.stderr.contains(named) && run.stderr.contains("not a regular file"), "{}", run.stderr);
    }
    fs::rename(place.path("pipe.obj"), place.path("pipe.json")).unwrap();
    place.run("simulate pipe.json").expect(&[2]);
}

#[test]
fn masses_that_do_not_fit_are_refused_with_what_to_do() {
    let place = Place::new();
    place.write("tiny.obj", "v 0 0 0\nv 1e-20 0 0\nv 1e-20 1e-20 0\nv 0 1e-20 0\nf 1 2 3 4\n");
    for args in ["tube.obj --density 1e-300", "tube.obj --density 1e300", "tiny.obj", "tube.obj --unit 1e-25"] {
        let run = place.run(&format!("build {args} -o a.gim --texels 400")).expect(&[2]);
        for word in ["--density", "--unit", "kg"] {
            assert!(run.stderr.contains(word) && !run.stderr.contains("manifest"), "{args}: {}", run.stderr);
        }
        assert!(!place.path("a.gim").exists());
    }
    place.run("build tiny.obj -o a.gim --unit 1e20 --texels 400").expect(&[0]);
}

#[test]
fn a_count_and_its_noun_are_said_once() {
    let place = Place::new();
    // The second sheet shares an edge with two quads of the tube.
    let tube = fs::read_to_string(place.path("tube.obj")).unwrap();
    place.write("fin.obj", &format!("{tube}v 0.5 0.1 0\nf 17 33 {}\n", 9 * 16 + 1));
    let run = place.run("build fin.obj -o fin.gim --texels 600").expect(&[1]);
    assert!(run.stderr.contains("non-manifold-edges: 1 edge with"), "{}", run.stderr);
    assert!(!run.stderr.contains("1x"), "{}", run.stderr);
    assert!(run.stderr.contains("(1 triangle)") && !run.stderr.contains("1 triangles"), "{}", run.stderr);
    // Coordinates have few digits: no number of the messages has more than seven.
    let long = run.stderr.split(|c: char| !c.is_ascii_digit() && c != '.').any(|word| word.len() > 9);
    assert!(!long, "{}", run.stderr);
}

#[test]
fn a_hint_about_unit_and_axis_is_shown_and_changes_nothing() {
    let place = Place::new();
    let tube = fs::read_to_string(place.path("tube.obj")).unwrap();
    // Centimetres, z up, one metre above the floor: the axes of the tube are turned by hand.
    let turned: String = tube
        .lines()
        .map(|line| match line.strip_prefix("v ") {
            Some(rest) => {
                let p: Vec<f64> = rest.split(' ').map(|x| x.parse().unwrap()).collect();
                format!("v {} {} {}\n", 100.0 * p[0], -100.0 * p[2], 100.0 * p[1] + 100.0)
            }
            None => format!("{line}\n"),
        })
        .collect();
    place.write("cm.obj", &turned);
    let run = place.run("build cm.obj -o cm.gim --texels 600").expect(&[0]);
    assert!(run.stderr.contains("hint: cm.obj: hint-unit: ") && run.stderr.contains("--unit 0.01?"), "{}", run.stderr);
    assert!(run.stderr.contains("--up Z?"), "{}", run.stderr);
    // Followed, they give what the upright file gives.
    let fixed =
        place.run("build cm.obj -o cm.gim --force --texels 600 --unit 0.01 --up z --center --json").expect(&[0]);
    assert!(!fixed.stderr.contains("hint"), "{}", fixed.stderr);
    let (fixed, plain) = (fixed.json(), place.built("--json").json());
    for end in ["min", "max"] {
        for k in 0..3 {
            let of = |json: &serde_json::Value| json["bounds"][end][k].as_f64().unwrap();
            assert!((of(&fixed) - of(&plain)).abs() < 0.02, "{} {}", fixed["bounds"], plain["bounds"]);
        }
    }
    assert_eq!((&fixed["options"]["up"], &fixed["options"]["center"]), (&"Z".into(), &true.into()));
    assert_eq!(fixed["pieces"][0]["surface"]["euler"], plain["pieces"][0]["surface"]["euler"]);
}

#[test]
fn limits_are_listed_by_inspect() {
    let place = Place::new();
    place.run("build tube.obj -o tube.gim --texels 600 --limit above:0.4=0.05 --limit above:0.6=0").expect(&[0]);
    let json = place.run("inspect tube.gim --json").expect(&[0]).json();
    let limits = &json["pieces"][0]["limits"];
    let (limited, all) = (limits["particles"].as_u64().unwrap(), json["texels"].as_u64().unwrap());
    assert!(limited > all / 3 && limited < 2 * all / 3, "{limited} of {all} particles");
    assert_eq!((limits["min"].as_f64(), limits["max"].as_f64()), (Some(0.0), Some(0.05)));
    let text = place.run("inspect tube.gim").expect(&[0]).stdout;
    assert!(text.contains("Limits") && text.contains("50.00 mm"), "{text}");
    let none = place.run("build tube.obj -o free.gim --texels 600").expect(&[0]).stdout;
    assert!(!none.contains("Limits"), "{none}");
}

#[test]
fn a_pin_that_selects_nothing_names_bounds_and_what_there_is() {
    let place = Place::new();
    let run = place.run("build tube.obj -o tube.gim --texels 600 --pin above:7 --pin loop:0").expect(&[1]);
    for words in ["nothing-pinned", "(above:7)", "y 0 to 0.8", "loop:0 to loop:1", "no attributes"] {
        assert!(run.stderr.contains(words), "{words}: {}", run.stderr);
    }
    assert!(!run.stderr.contains("loop:0)"), "{}", run.stderr);
}

/// Kills builds over an existing bundle at all moments: what is left is sound, the old one or the new one, and the next
/// build removes what lies about.
#[test]
#[cfg(unix)]
fn a_killed_build_leaves_the_old_or_the_new_bundle() {
    use std::process::{Command, Stdio};
    use std::time::{Duration, Instant};
    let place = Place::new();
    place.built("--no-metrics");
    let start = Instant::now();
    place.built("--no-metrics --force");
    let whole = start.elapsed();
    let known = [bytes(&place.path("tube.gim")), {
        place.built("--no-metrics --force --density 0.2");
        bytes(&place.path("tube.gim"))
    }];
    for round in 0..32 {
        let density = ["0.15", "0.2"][round % 2];
        let mut command = Command::new(env!("CARGO_BIN_EXE_gimage"));
        let args = format!("build tube.obj -o tube.gim --texels 600 --force --no-metrics --density {density}");
        command.current_dir(place.0.path()).args(args.split_whitespace()).stdout(Stdio::null()).stderr(Stdio::null());
        let mut child = command.spawn().unwrap();
        // Most of the writing is in the last third.
        std::thread::sleep(whole.mul_f64(0.3 + 0.9 * round as f64 / 32.0).min(Duration::from_secs(5)));
        child.kill().unwrap();
        child.wait().unwrap();
        let found = bytes(&place.path("tube.gim"));
        assert!(known.contains(&found), "round {round}: {:?}", found.iter().map(|f| &f.0).collect::<Vec<_>>());
        place.run("validate tube.gim").expect(&[0]);
    }
    place.built("--no-metrics --force");
    assert_eq!(place.list(), ["tube.gim", "tube.obj"]);
}

/// Waves around cells like needles got shorter by ever less, and tethers took hours.
#[test]
fn tethers_are_found_where_cells_are_squeezed_to_needles() {
    let place = Place::new();
    place.write("arrow.obj", "v 0 0 0\nv 2 0 0\nv 0.5 0.5 0\nv 0 2 0\nv -1 -1 0\nf 2 3 4 1\nf 1 5 2\n");
    place.run("dress arrow.obj -o arrow.gim").expect(&[0, 1]);
    place.run("validate arrow.gim").expect(&[0, 1]);
}
