//! Help, flags, and how errors look.

use crate::common::Place;

#[test]
fn help_has_examples_and_exit_codes() {
    let place = Place::new();
    for command in [
        "",
        "build",
        "list",
        "inspect",
        "validate",
        "reconstruct",
        "simulate",
        "render",
        "export",
        "dress",
        "fit-colliders",
        "check-crossings",
        "doctor",
    ] {
        for flag in ["--help", "-h"] {
            let run = place.run(&format!("{command} {flag}")).expect(&[0]);
            assert!(
                run.stdout.contains("EXAMPLES:") && run.stdout.contains("EXIT CODES:"),
                "{command}: {}",
                run.stdout
            );
            assert!(run.stdout.contains(&format!("gimage {command}")) && run.stderr.is_empty());
        }
    }
    assert!(place.run("--version").expect(&[0]).stdout.starts_with("gimage "));
    assert!(place.run("").expect(&[2]).stdout.is_empty());
}

#[test]
fn bad_flags_exit_2_with_words_on_stderr_only() {
    let place = Place::new();
    for args in [
        "frobnicate",
        "build",
        "build tube.obj",
        "build tube.obj -o a.gim --bogus",
        "build tube.obj -o a.gim --texels 3",
        "build tube.obj -o a.gim --texels many",
        "build tube.obj -o a.gim --size 2x2",
        "build tube.obj -o a.gim --size 9x9 --texels 100",
        "build tube.obj -o a.gim --accessory-area 2",
        "build tube.obj -o a.gim --unit 0",
        "build tube.obj -o a.gim --pin sideways:1",
        "build tube.obj -o a.gim --density -1",
        "build tube.obj -o a.gim --cloth skirt",
        "build tube.obj -o a.gim --body ,",
        "list",
        "list tube.obj --cloth skirt",
        "fit-colliders",
        "fit-colliders tube.obj --collider-error 0",
        "fit-colliders tube.obj --max-colliders 0",
        "fit-colliders tube.obj --collider-shapes cone",
        "fit-colliders tube.obj --body nobody",
        "inspect",
        "reconstruct a.gim",
        "export",
        "export s1",
        "export s1 -o a.stl",
        "export s1 -o a",
        "export s1 -o a.usda --as meshes",
        "export s1 -o a.glb --as points",
        "export s1 -o a.glb --frames 0",
        "export s1 -o a.glb --every 0",
        "export s1 -o a.glb --fps 0",
        "export s1 -o a.glb --fps 24 --every 2",
        "export s1 -o a.glb --frames 4 --from 5",
        "export s1 -o no/a.glb",
        "export s1 -o tube.obj/a.obj",
        "check-crossings",
        "check-crossings a.gim --n 9",
        "reconstruct a.gim -o mesh.stl",
    ] {
        let before = place.list();
        let run = place.run(args).expect(&[2]);
        assert!(run.stdout.is_empty(), "{args}: {}", run.stdout);
        assert!(run.stderr.contains("error: ") || args == "build", "{args}: {}", run.stderr);
        assert_eq!(place.list(), before, "{args}");
    }
}

#[test]
fn a_scene_is_named_by_position_or_by_flag() {
    let place = Place::new();
    place.built("-q");
    let of = |args: &str| {
        let mut json = place.run(&format!("simulate {args} --frames 3 --backend cpu --json")).expect(&[0]).json();
        for time in ["ms_frame_min", "ms_frame_median"] {
            json.as_object_mut().unwrap().remove(time);
        }
        json
    };
    for (scene, more) in [("s3", "--n 9"), ("tube.gim", "--substeps 2")] {
        assert_eq!(of(&format!("{scene} {more}")), of(&format!("--scene {scene} {more}")));
    }
    place.run("render --scene s1 --n 9 -o a.png --size 32x32 --backend cpu").expect(&[0]);
    for args in ["simulate", "simulate s1 --scene s3", "render -o b.png"] {
        assert!(place.run(args).expect(&[2]).stderr.contains("SCENE"), "{args}");
    }
}

#[test]
fn a_missing_file_is_named() {
    let place = Place::new();
    for args in [
        "build no/such.obj -o a.gim",
        "list no/such.obj",
        "fit-colliders no/such.obj",
        "inspect no/such.gim",
        "validate no/such.gim",
        "check-crossings no/such.gim",
    ] {
        let run = place.run(args).expect(&[2]);
        let name = args.split_whitespace().nth(1).unwrap();
        assert!(run.stderr.starts_with("error: ") && run.stderr.contains(name), "{}", run.stderr);
        assert!(run.stdout.is_empty());
        let json = place.run(&format!("{args} --json")).expect(&[2]).json();
        assert!(json["error"].as_str().unwrap().contains(name) && json["exit"] == 2, "{json}");
    }
    for name in ["nope.json", "no/such.gim"] {
        for command in [format!("simulate {name}"), format!("export {name} -o a.glb")] {
            let run = place.run(&command).expect(&[2]);
            assert!(run.stderr.starts_with(&format!("error: {name}: no such file")), "{}", run.stderr);
        }
    }
    let run = place.run("reconstruct no/such.gim -o a.obj").expect(&[2]);
    assert!(run.stderr.contains("no/such.gim"), "{}", run.stderr);
    let json = place.run("build tube.obj -o a.gim --bogus --json").expect(&[2]).json();
    assert!(json["error"].as_str().unwrap().contains("--bogus"), "{json}");
}

#[test]
fn quiet_says_nothing_and_colour_is_never_in_a_pipe() {
    let place = Place::new();
    let run = place.built("-q");
    assert!(run.stderr.is_empty() && !run.stdout.is_empty(), "{}", run.stderr);
    for args in ["inspect tube.gim -v", "inspect none.gim", "build tube.obj -o tube.gim", "build --help", "--bad"] {
        for colour in ["", "1"] {
            let run = place.run_with(args, |c| {
                c.env("NO_COLOR", colour);
            });
            assert!(!run.stdout.contains('\x1b') && !run.stderr.contains('\x1b'), "{args}");
        }
    }
}

#[test]
#[cfg(target_os = "linux")]
fn a_reader_that_goes_away_is_no_error() {
    let place = Place::new();
    place.built("");
    for args in ["inspect tube.gim", "inspect tube.gim --json", "--help"] {
        let (reader, writer) = std::io::pipe().unwrap();
        drop(reader);
        let run = place.run_with(args, |c| {
            c.stdout(writer);
        });
        assert!(run.code == 0 && run.stderr.is_empty(), "{args}: {} {}", run.code, run.stderr);
    }
}
