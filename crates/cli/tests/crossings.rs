//! `gimage check-crossings`.

use crate::common::Place;

#[test]
fn a_bundle_at_rest_has_none() {
    let place = Place::new();
    place.built("");
    let run = place.run("check-crossings tube.gim").expect(&[0]);
    assert!(
        run.stdout.contains("rest") && run.stderr.contains("no crossings at rest"),
        "{} {}",
        run.stdout,
        run.stderr
    );
    let json = place.run("check-crossings tube.gim --json").expect(&[0]).json();
    let rest = &json["inputs"][0]["frames"][0];
    assert!(rest["frame"].is_null() && rest["triangles"].as_u64() > Some(500), "{json}");
    assert_eq!(
        (rest["within"].as_u64(), rest["touching"].as_u64(), json["exit"].as_u64()),
        (Some(0), Some(0), Some(0))
    );
}

#[test]
fn dumped_frames_are_checked_with_and_without_the_scene() {
    let place = Place::new();
    place.built("");
    place.run("simulate tube.gim --frames 4 --backend cpu --dump frames --every 2").expect(&[0, 1]);
    let check = |more: &str| place.run(&format!("check-crossings frames {more} --json")).expect(&[0]).json();
    let (alone, known) = (check(""), check("--scene tube.gim"));
    assert_eq!(alone["inputs"][0]["frames"], known["inputs"][0]["frames"]);
    let frames = alone["inputs"][0]["frames"].as_array().unwrap();
    let numbers: Vec<_> = frames.iter().map(|f| f["frame"].as_u64().unwrap()).collect();
    assert_eq!(numbers, [0, 2, 4]);
    let run = place.run("check-crossings frames tube.gim").expect(&[0]);
    assert!(run.stdout.contains("frame") && run.stderr.contains("no crossings in 3 frames"), "{}", run.stderr);
}

/// Two squares of 1 m as an OBJ; the second one stands across the first.
fn crossed_squares() -> String {
    let (n, mut obj) = (13, String::new());
    for upright in [false, true] {
        for k in 0..n * n {
            let (u, v) = ((k % n) as f64 / (n - 1) as f64, (k / n) as f64 / (n - 1) as f64);
            let [x, y, z] = if upright { [0.1 + 0.8 * u, v - 0.5, 0.43 + 0.1 * u] } else { [u, 0.0, v] };
            obj += &format!("v {x} {y} {z}\n");
        }
        let first = if upright { n * n + 1 } else { 1 };
        for (i, j) in (0..n - 1).flat_map(|j| (0..n - 1).map(move |i| (i, j))) {
            let k = first + j * n + i;
            obj += &format!("f {} {} {} {}\n", k, k + n, k + n + 1, k + 1);
        }
    }
    obj
}

#[test]
fn a_run_says_how_many_triangles_cross_at_its_end() {
    let place = Place::new();
    place.write("crossed.obj", &crossed_squares());
    place.run("build crossed.obj -o crossed.gim --texels 512").expect(&[0, 1]);
    let rest = &place.run("check-crossings crossed.gim --json").expect(&[1]).json()["inputs"][0]["frames"][0];
    let pairs = rest["within"].as_u64().unwrap() + rest["between"].as_u64().unwrap();
    let count = |json: &serde_json::Value, name: &str| json["crossings"][name].as_u64();
    let still = place.run("render crossed.gim -o a.png --backend cpu --time 0 --size 32x32 --json").expect(&[0]);
    let json = still.json();
    let end = count(&json, "within").unwrap() + count(&json, "between").unwrap();
    assert_eq!((end, count(&json, "start")), (pairs, Some(pairs)));
    // Crossings at rest have no note.
    assert!(!still.stderr.contains("triangles cross"), "{}", still.stderr);
    // Two squares, the upper one 4 cm above the lower one, which is held; the upper one leans, so that it takes a while to fall through.
    let square = |first: usize, lean: f64, height: f64| {
        let point = |k: usize| ((k % 13) as f64 / 12.0, (k / 13) as f64 / 12.0);
        let points = (0..169).map(point).map(|(x, z)| format!("v {x} {} {z}\n", height + lean * x));
        let quads = (0..156).filter(|k| k % 13 < 12).map(|k| first + k);
        let quads = quads.map(|k| format!("f {} {} {} {}\n", k, k + 13, k + 14, k + 1));
        points.collect::<String>() + &quads.collect::<String>()
    };
    place.write("stack.obj", &(square(1, 0.0, 0.0) + &square(170, 0.3, 0.04)));
    place.run("build stack.obj -o stack.gim --texels 512 --pin below:0.01").expect(&[0, 1]);
    let fall = |more: &str| {
        let run = place.run(&format!("simulate stack.gim --backend cpu --frames 9 {more}"));
        assert!(run.code < 2, "{}", run.stderr);
        run
    };
    let fallen = fall("").stderr;
    for words in [
        "triangles cross at the end, by at most",
        "the deepest mostly of 'piece' and 'piece_2'",
        "cloth has no contact",
    ] {
        assert!(fallen.contains(words), "{words}: {fallen}");
    }
    let json = fall("--json").json();
    assert!(count(&json, "between").unwrap() + count(&json, "within").unwrap() > 5, "{json}");
    assert_eq!(count(&json, "start"), Some(0));
    let kept = fall("--contact safe --json");
    let (json, stderr) = (kept.json(), kept.stderr);
    assert!(json["crossings"]["start"].is_null() && !stderr.contains("triangles cross"), "{stderr}");
    // Cloth that crosses nowhere has no such note.
    let run = place.run("simulate s1 --n 8 --backend cpu --frames 3").expect(&[0]);
    assert!(!run.stderr.contains("cross"), "{}", run.stderr);
}

#[test]
fn inspect_counts_crossings_at_rest_and_draws_them() {
    let place = Place::new();
    place.write("crossed.obj", &crossed_squares());
    place.run("build crossed.obj -o crossed.gim --texels 512").expect(&[0, 1]);
    let counted = place.run("check-crossings crossed.gim --json").expect(&[1]).json();
    let frame = &counted["inputs"][0]["frames"][0];
    let pairs = frame["within"].as_u64().unwrap() + frame["between"].as_u64().unwrap();
    let json = place.run("inspect crossed.gim --picture crossed.png --json").expect(&[0, 1]).json();
    assert!(pairs > 5, "{counted}");
    assert_eq!(json["crossings"]["pairs"].as_u64(), Some(pairs));
    let image = image::open(place.path("crossed.png")).unwrap().into_rgb8();
    assert_eq!(image.dimensions(), (1280, 640));
    // Red in both parts, and no red where nothing crosses.
    let red = |left: u32| {
        let columns = left..left + 640;
        columns
            .flat_map(|x| (0..640).map(move |y| (x, y)))
            .filter(|(x, y)| {
                let [r, g, _] = image.get_pixel(*x, *y).0;
                u32::from(r) > 2 * u32::from(g)
            })
            .count()
    };
    assert!(red(0) > 500 && red(640) > 500, "{} {}", red(0), red(640));
    assert!(
        place.run("inspect crossed.gim").expect(&[0, 1]).stdout.contains(&format!("{pairs} pairs of triangles cross"))
    );
    place.run("inspect crossed.gim --picture crossed.png").expect(&[2]);
    place.run("inspect crossed.gim --picture crossed.jpg").expect(&[2]);
    place.built("");
    place.run("inspect tube.gim --picture crossed.png --force").expect(&[0]);
    assert_eq!(image::open(place.path("crossed.png")).unwrap().into_rgb8().dimensions(), (640, 640));
}

/// Two sheets, of which the wind takes one through the other.
const SHEETS: &str = r#"{
  "format": "gimage-scene", "version": 1, "name": "sheets", "duration": 0.2,
  "cloths": [
    { "name": "low", "from": { "flat": { "width": 9, "height": 9, "origin": [0, 0, 0], "right": [1, 0, 0], "down": [0, 0, 1] } },
      "pins": [{ "select": { "texels": { "from": [0, 0], "to": [8, 8] } } }] },
    { "name": "high", "from": { "flat": { "width": 6, "height": 6, "origin": [0.2, 0.1, 0.2], "right": [0.5, 0.2, 0], "down": [0, 0, 0.5] } } }
  ]
}"#;

#[test]
fn a_sheet_that_falls_through_another_crosses_it() {
    let place = Place::new();
    place.write("sheets.json", SHEETS);
    place.run("simulate sheets.json --frames 12 --backend cpu --dump frames --every 12").expect(&[0, 1]);
    for more in ["", "--scene sheets.json"] {
        let run = place.run(&format!("check-crossings frames {more} --json")).expect(&[1]);
        assert!(run.stderr.contains("crossings in 1 of 2 frames"), "{}", run.stderr);
        let json = run.json();
        let [first, last] = [0, 1].map(|k| &json["inputs"][0]["frames"][k]);
        assert_eq!((first["between"].as_u64(), first["within"].as_u64()), (Some(0), Some(0)), "{json}");
        assert!(last["between"].as_u64() > Some(5) && last["within"].as_u64() == Some(0), "{json}");
        let worst = &last["worst"][0];
        assert!(worst["depth_m"].as_f64() == last["deepest_m"].as_f64() && worst["depth_m"].as_f64() > Some(0.001));
        let mut pieces = ["first", "second"].map(|k| worst[k]["piece"].as_str().unwrap());
        pieces.sort_unstable();
        assert_eq!(pieces, ["high", "low"]);
    }
    let run = place.run("check-crossings frames -v").expect(&[1]);
    assert!(run.stdout.contains("frame 12: high (") && run.stdout.contains(" and low ("), "{}", run.stdout);
}

#[test]
fn other_scenes_and_folders_are_refused() {
    let place = Place::new();
    place.built("");
    std::fs::create_dir(place.path("empty")).unwrap();
    place.run("simulate s1 --n 9 --frames 1 --backend cpu --dump frames").expect(&[0, 1]);
    for (args, words) in [
        ("check-crossings empty", "neither frames nor a manifest.json"),
        ("check-crossings tube.obj", "not a directory"),
        ("check-crossings frames --scene s1 --n 8", "--scene"),
        ("check-crossings frames --scene tube.gim", "not a piece of the scene"),
        ("check-crossings frames --scene s9", "s2f"),
    ] {
        let run = place.run(args).expect(&[2]);
        assert!(run.stderr.contains(words) && run.stdout.is_empty(), "{args}: {}", run.stderr);
    }
    place.run("check-crossings frames --scene s1 --n 9").expect(&[0]);
}
