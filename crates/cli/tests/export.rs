//! `gimage export`: the motion in files is the motion of the simulation.

use std::fs;

use crate::common::{self, Place};
use gimage_bundle::{decode_exr, dir::read_dir};
use gimage_runtime::Cloth;

/// Positions of the corners of all triangles that are drawn, of each frame.
type Frames = Vec<Vec<[f32; 3]>>;

/// A tube that hangs by its top, and the corners of its triangles in every third frame of 12 from frame 3 on, as dumped.
fn simulated() -> (Place, Frames) {
    let place = Place::new();
    place.built("--pin above:0.75");
    place.run("simulate tube.gim --backend cpu --frames 12 --every 3 --dump-from 3 --dump dump").expect(&[0, 1]);
    let cloth = Cloth::from_bundle("tube", &read_dir(&place.path("tube.gim")).unwrap()).unwrap();
    let points = cloth.points();
    let corners: Vec<u32> = cloth.indices();
    let welded = corners.as_chunks::<3>().0.iter().map(|t| t.map(|k| points[k as usize]));
    let welded: Vec<u32> = welded.filter(|[a, b, c]| a != b && b != c && c != a).flatten().collect();
    let frame = |k: u32| {
        let path = place.path(&format!("dump/frame_{k:05}.tube.position.exr"));
        let image = decode_exr("frame", &fs::read(path).unwrap()).unwrap();
        welded.iter().map(|k| *image.at(*k as usize).first_chunk().unwrap()).collect()
    };
    let frames = [3, 6, 9, 12].map(frame).into();
    (place, frames)
}

const FLAGS: &str = "--surface grid --backend cpu --frames 12 --every 3 --from 3 --json";

/// Fails unless positions are the same to the rounding of `ulps` of a number of 1.
#[track_caller]
fn compare(found: &Frames, expected: &Frames, ulps: f32) {
    assert_eq!(found.len(), expected.len());
    for (k, (found, expected)) in found.iter().zip(expected).enumerate() {
        assert_eq!(found.len(), expected.len(), "frame {k}");
        for (a, b) in found.iter().zip(expected) {
            assert!((0..3).all(|c| (a[c] - b[c]).abs() <= ulps * f32::EPSILON), "frame {k}: {a:?} {b:?}");
        }
    }
}

/// The frames of a GLB file with one mesh whose targets are frames.
fn glb_targets(bytes: &[u8]) -> Frames {
    let file = gltf::Gltf::from_slice(bytes).unwrap();
    let (document, blob) = (file.document, file.blob.unwrap());
    let primitive = document.meshes().next().unwrap().primitives().next().unwrap();
    let reader = primitive.reader(|_| Some(&blob));
    let first: Vec<_> = reader.read_positions().unwrap().collect();
    let indices: Vec<_> = reader.read_indices().unwrap().into_u32().collect();
    assert!(reader.read_tex_coords(0).is_some() && reader.read_normals().is_some());
    let target = |deltas: Vec<[f32; 3]>| {
        let moved = first.iter().zip(deltas).map(|(p, d)| [0, 1, 2].map(|c| p[c] + d[c]));
        moved.collect::<Vec<_>>()
    };
    let targets = reader.read_morph_targets().map(|(p, _, _)| target(p.unwrap().collect()));
    let all: Vec<_> = std::iter::once(first.clone()).chain(targets).collect();
    all.iter().map(|p| indices.iter().map(|k| p[*k as usize]).collect()).collect()
}

/// Corners of the triangles of an OBJ file.
fn obj_corners(text: &str) -> Vec<[f32; 3]> {
    let lines = |start: &'static str| text.lines().filter_map(move |line| line.strip_prefix(start));
    let numbers = |line: &str| line.split(' ').map(|x| x.parse().unwrap()).collect::<Vec<f32>>();
    let positions: Vec<[f32; 3]> = lines("v ").map(|line| numbers(line).try_into().unwrap()).collect();
    assert_eq!(lines("vn ").count(), positions.len());
    let uv = lines("vt ").count();
    let corner = |corner: &str| {
        let three: Vec<usize> = corner.split('/').map(|k| k.parse().unwrap()).collect();
        assert!(three[0] == three[2] && three[1] <= uv);
        positions[three[0] - 1]
    };
    lines("f ").flat_map(|line| line.split(' ')).map(corner).collect()
}

#[test]
fn glb_frames_are_those_of_the_dump_for_any_threads() {
    let (place, frames) = simulated();
    let run = place.run(&format!("export tube.gim -o a.glb {FLAGS} --threads 1")).expect(&[0, 1]).json();
    place.run(&format!("export tube.gim -o b.glb {FLAGS} --threads 2")).expect(&[0, 1]);
    let bytes = fs::read(place.path("a.glb")).unwrap();
    assert!(bytes == fs::read(place.path("b.glb")).unwrap());
    // A difference and a sum, each rounded.
    compare(&glb_targets(&bytes), &frames, 1.0);
    assert_eq!(run["bytes"].as_u64(), Some(bytes.len() as u64));
    assert_eq!((run["frames"].as_u64(), run["frames_per_second"].as_f64()), (Some(4), Some(20.0)));
    assert_eq!((run["seconds"].as_f64(), run["pieces"].as_u64()), (Some(0.15), Some(1)));
    assert_eq!(run["triangles"].as_u64(), Some(frames[0].len() as u64 / 3));
    assert_eq!(run["files"].as_array().map(Vec::len), Some(1));
    let shown = place.run(&format!("export tube.gim -o c.glb --as meshes {FLAGS}")).expect(&[0, 1]).json();
    let meshes = gltf::Gltf::from_slice(&fs::read(place.path("c.glb")).unwrap()).unwrap();
    assert_eq!((meshes.meshes().count(), shown["frames"].as_u64()), (4, Some(4)));
}

#[test]
fn usd_frames_are_those_of_the_dump() {
    let (place, frames) = simulated();
    place.run(&format!("export tube.gim -o tube.usda {FLAGS}")).expect(&[0, 1]);
    let text = fs::read_to_string(place.path("tube.usda")).unwrap();
    assert!(text.contains("timeCodesPerSecond = 20\n") && text.contains("def Mesh \"tube\""), "{text}");
    let numbers = |text: &str| -> Vec<f32> {
        let parts = text.split(|c: char| !"0123456789.-".contains(c)).filter(|part| !part.is_empty());
        parts.map(|part| part.parse().unwrap()).collect()
    };
    let indices = text.lines().find_map(|line| line.trim().strip_prefix("int[] faceVertexIndices = ")).map(numbers);
    let samples = text.split("point3f[] points.timeSamples = {\n").nth(1).unwrap();
    let samples =
        samples.lines().take_while(|line| line.trim() != "}").map(|line| line.trim().split_once(": ").unwrap());
    let frame = |(code, (at, text)): (usize, (&str, &str))| {
        assert_eq!(at, (code + 1).to_string());
        let points = numbers(text);
        let corner = |k: &f32| *points[3 * *k as usize..].first_chunk().unwrap();
        indices.as_ref().unwrap().iter().map(corner).collect()
    };
    compare(&samples.enumerate().map(frame).collect(), &frames, 0.0);
}

#[test]
fn obj_frames_are_those_of_the_dump_and_replace_older_ones() {
    let (place, frames) = simulated();
    fs::create_dir(place.path("out")).unwrap();
    let export = |flags: &str| place.run(&format!("export tube.gim -o out/tube.obj {flags}"));
    let run = export(FLAGS).expect(&[0, 1]).json();
    let names = [1, 2, 3, 4].map(|k| format!("tube_{k:05}.obj"));
    assert_eq!(common::list(&place.path("out")), names);
    let listed: Vec<_> = run["files"].as_array().unwrap().iter().map(|f| f.as_str().unwrap()).collect();
    assert_eq!(listed, names.clone().map(|name| format!("out/{name}")));
    let text = |name: &String| fs::read_to_string(place.path("out").join(name)).unwrap();
    let sizes: usize = names.iter().map(|name| text(name).len()).sum();
    assert_eq!(run["bytes"].as_u64(), Some(sizes as u64));
    compare(&names.iter().map(|name| obj_corners(&text(name))).collect(), &frames, 0.0);
    fs::write(place.path("out/tube_2.obj"), "mine").unwrap();
    let refused = export("--backend cpu --frames 1").expect(&[2]).stderr;
    assert!(refused.contains("tube_00001.obj") && refused.contains("--force"), "{refused}");
    export("--backend cpu --frames 1 --force").expect(&[0, 1]);
    assert_eq!(common::list(&place.path("out")), ["tube_00001.obj", "tube_00002.obj", "tube_2.obj"]);
    // A frame reads back as a garment.
    place.run("build out/tube_00002.obj -o again.gim --texels 300").expect(&[0, 1]);
}

#[test]
fn the_rate_of_film_is_kept_between_steps() {
    let place = Place::new();
    let json = |flags: &str, out: &str| {
        let run =
            place.run(&format!("export s1 --n 9 --substeps 32 --backend cpu --frames 60 --json -o {out} {flags}"));
        run.expect(&[0]).json()
    };
    for (fps, frames) in [("24", 25), ("30", 31), ("20", 21), ("29.97", 30)] {
        let run = json(&format!("--fps {fps}"), &format!("a{fps}.usda"));
        assert_eq!(run["frames"].as_u64(), Some(frames));
        assert!((run["frames_per_second"].as_f64().unwrap() - fps.parse::<f64>().unwrap()).abs() < 1e-9);
        let text = fs::read_to_string(place.path(&format!("a{fps}.usda"))).unwrap();
        assert!(text.contains(&format!("timeCodesPerSecond = {fps}\n")), "{fps}");
    }
    json("--every 2", "b.usda");
    // The name of the root follows that of the file.
    let text = |name: &str| fs::read_to_string(place.path(name)).unwrap();
    assert_eq!(text("a30.usda").replace("\"a30\"", "\"b\""), text("b.usda"));
    json("--fps 24", "c.glb");
    json("--every 1", "d.glb");
    let (film, all) = (fs::read(place.path("c.glb")).unwrap(), fs::read(place.path("d.glb")).unwrap());
    let (film, all) = (glb_targets(&film), glb_targets(&all));
    // 2 frames at 24 per second take as long as 5 at 60, and lie at most a step earlier: 0.5 ms, at about 4 m/s.
    for k in 0..12 {
        compare(&film[2 * k..=2 * k].to_vec(), &all[5 * k..=5 * k].to_vec(), 3e4);
    }
    let y = |frame: &[[f32; 3]]| frame.iter().map(|p| p[1]).fold(f32::INFINITY, f32::min);
    assert!(y(&film[1]) < y(&all[2]) && y(&film[1]) > y(&all[3]), "{} {} {}", y(&film[1]), y(&all[2]), y(&all[3]));
}

#[test]
fn a_cut_takes_triangles_away_from_its_frame_on() {
    let place = Place::new();
    let cloth = r#"{"from": {"flat": {"width": 9, "height": 9, "origin": [-0.5, 1, 0], "right": [1, 0, 0], "down": [0, -1, 0]}},
                    "name": "curtain", "pins": [{"select": {"texels": {"from": [0, 0], "to": [8, 0]}}}]}"#;
    let cut = r#"{"time": 0.09, "eye": [0.02, 0.5, 2], "a": [0.02, 1.5, -2], "b": [0.02, -1.5, -2]}"#;
    place.write(
        "cut.json",
        &format!(r#"{{"format": "gimage-scene", "version": 1, "cloths": [{cloth}], "cuts": [{cut}]}}"#),
    );
    let flags = "--backend cpu --frames 12 --every 3";
    for out in ["cut.obj", "cut.usda", "cut.glb"] {
        place.run(&format!("export cut.json {flags} -o {out}")).expect(&[0, 1]);
    }
    let faces = |k: usize| {
        let text = fs::read_to_string(place.path(&format!("cut_{k:05}.obj"))).unwrap();
        text.lines().filter(|line| line.starts_with("f ")).count()
    };
    let counts = [1, 2, 3, 4, 5].map(faces);
    assert!(counts[..2] == [128; 2] && counts[2] < 128 && counts[2..] == [counts[2]; 3], "{counts:?}");
    let text = fs::read_to_string(place.path("cut.usda")).unwrap();
    let samples = text.split("int[] faceVertexCounts.timeSamples = {\n").nth(1).unwrap();
    let codes =
        samples.lines().take_while(|line| line.trim() != "}").map(|line| line.trim().split(':').next().unwrap());
    assert_eq!(codes.collect::<Vec<_>>(), ["1", "3"]);
    let glb = gltf::Gltf::from_slice(&fs::read(place.path("cut.glb")).unwrap()).unwrap();
    let count = |mesh: gltf::Mesh| mesh.primitives().next().unwrap().indices().unwrap().count() / 3;
    assert_eq!(glb.meshes().map(count).collect::<Vec<_>>(), [128, counts[2]]);
}

#[test]
fn cloth_that_is_not_finite_leaves_no_file() {
    let place = Place::new();
    let cloth =
        r#"{"from": {"flat": {"width": 9, "height": 9, "right": [1, 0, 0], "down": [0, 0, 1]}}, "name": "flag"}"#;
    let text = format!(
        r#"{{"format": "gimage-scene", "version": 1, "gravity": [0, -1e38, 0], "duration": 1, "cloths": [{cloth}]}}"#
    );
    place.write("storm.json", &text);
    let before = place.list();
    for out in ["a.glb", "a.usda", "a.obj"] {
        let run = place.run(&format!("export storm.json --backend cpu --solver classic -o {out}")).expect(&[2]);
        for words in ["cloth 'flag': particle", "not finite or farther than 1e8 m", "xpbd"] {
            assert!(run.stderr.contains(words), "{words}: {}", run.stderr);
        }
        assert_eq!(place.list(), before);
    }
    let finds = place.run("export storm.json --backend cpu -o a.glb --json").expect(&[1]);
    assert!(finds.json()["faults"][0]["frames_taken_back"].as_u64() > Some(0));
}

#[test]
fn existing_files_and_places_that_cannot_be_written_are_refused() {
    let place = Place::new();
    place.write("a.glb", "mine");
    fs::create_dir(place.path("b.glb")).unwrap();
    let refused = |out: &str, words: &str| {
        let run = place.run(&format!("export s1 --n 9 --backend cpu --frames 2 -o {out}")).expect(&[2]);
        assert!(run.stderr.contains(words), "{out}: {}", run.stderr);
    };
    refused("a.glb", "--force");
    refused("b.glb", "it is a directory");
    refused("no/a.obj", "make the directory first");
    if cfg!(target_os = "linux") {
        refused("/proc/a.usda", "/proc");
    }
    assert_eq!(fs::read(place.path("a.glb")).unwrap(), b"mine");
    place.run("export s1 --n 9 --backend cpu --frames 2 -o a.glb --force").expect(&[0]);
    assert_eq!(&fs::read(place.path("a.glb")).unwrap()[..4], b"glTF");
    assert_eq!(place.list(), ["a.glb", "b.glb", "tube.obj"]);
}

/// Files have a limit in size, as on a full disk.
#[cfg(unix)]
#[test]
fn a_full_disk_leaves_no_file() {
    let place = Place::new();
    for out in ["a.glb", "a.usda", "a.obj"] {
        let run = format!("export s1 --backend cpu --n 40 --frames 9 -o {out}");
        let text = format!("trap '' XFSZ; ulimit -f 40; exec {} {run}", env!("CARGO_BIN_EXE_gimage"));
        let mut shell = std::process::Command::new("sh");
        let out = shell.arg("-c").arg(text).current_dir(place.0.path()).output().unwrap();
        let words = String::from_utf8_lossy(&out.stderr);
        assert!(out.status.code() == Some(2) && words.contains("a"), "{words}");
        assert_eq!(place.list(), ["tube.obj"], "{words}");
    }
}

#[test]
fn an_animation_moves_the_surface() {
    let place = Place::new();
    let assets = std::path::Path::new(env!("CARGO_MANIFEST_DIR")).join("../../assets");
    fs::copy(assets.join("sleeve.glb"), place.path("sleeve.glb")).unwrap();
    place.run("build sleeve.glb -o sleeve.gim --texels 600 --pin box:0.1,1,-1,0.205,2,1").expect(&[0, 1]);
    let flags = "--backend cpu --frames 30 --every 30 --animation swing";
    place.run(&format!("export sleeve.gim -o a.glb {flags}")).expect(&[0, 1]);
    let frames = glb_targets(&fs::read(place.path("a.glb")).unwrap());
    let far = frames[0].iter().zip(&frames[1]).map(|(a, b)| (0..3).map(|c| (a[c] - b[c]).abs()).fold(0.0, f32::max));
    assert!(far.fold(0.0, f32::max) > 0.05);
}

#[test]
fn the_mesh_of_the_source_is_exported_as_the_wrap_moves_it() {
    let place = Place::new();
    let assets = std::path::Path::new(env!("CARGO_MANIFEST_DIR")).join("../../assets");
    fs::copy(assets.join("sleeve.glb"), place.path("sleeve.glb")).unwrap();
    place.run("build sleeve.glb -o sleeve.gim --texels 600 --pin box:0.1,1,-1,0.205,2,1").expect(&[0, 1]);
    let flags = "--backend cpu --frames 30 --every 30 --surface render --json";
    let run = place.run(&format!("export sleeve.gim -o a.obj {flags}")).expect(&[0, 1]).json();
    assert_eq!(run["surface"].as_str(), Some("render"));
    let moved = |k: usize| obj_corners(&fs::read_to_string(place.path(&format!("a_{k:05}.obj"))).unwrap());
    // At rest it is the source.
    let bundle = gimage_bundle::dir::read_dir(&place.path("sleeve.gim")).unwrap();
    let mesh = gimage_runtime::RenderMesh::from_bundle(&bundle).unwrap().unwrap();
    let source = gimage_bundle::RenderFile::parse(bundle.render.as_ref().unwrap()).unwrap().primitives().unwrap();
    let source: Vec<[f32; 3]> =
        source.iter().flat_map(|p| p.indices.iter().map(|v| p.positions[*v as usize])).collect();
    let far = |a: &[[f32; 3]], b: &[[f32; 3]]| {
        assert_eq!(a.len(), b.len());
        a.iter().zip(b).flat_map(|(a, b)| (0..3).map(move |c| (a[c] - b[c]).abs())).fold(0.0, f32::max)
    };
    let first = far(&moved(1), &source);
    assert!(first < 1e-6, "{first}");
    // Later it is the wrap of a stepper.
    let mut scene = gimage_runtime::Scene::new("sleeve.gim");
    scene.cloths.push(gimage_runtime::Cloth::from_bundle("sleeve.gim", &bundle).unwrap());
    let mut stepper = gimage_runtime::Stepper::on_cpu(scene, gimage_runtime::Options::default()).unwrap();
    (0..30).for_each(|_| _ = stepper.advance(1.0 / 60.0).unwrap());
    let mut vertices = Vec::new();
    stepper.wrap(0, &mesh, 1.0, &mut vertices).unwrap();
    let at = |v: &u32| vertices[*v as usize].position.first_chunk().copied().unwrap();
    let wrapped: Vec<[f32; 3]> = mesh.indices.iter().map(at).collect();
    assert_eq!(far(&moved(2), &wrapped), 0.0);
    let fell = far(&moved(2), &source);
    assert!(fell > 1e-3, "{fell}");
}

#[test]
fn the_mesh_of_a_cut_garment_of_a_scene_parts_at_the_cut() {
    let place = Place::new();
    let assets = std::path::Path::new(env!("CARGO_MANIFEST_DIR")).join("../../assets");
    fs::copy(assets.join("sleeve.glb"), place.path("sleeve.glb")).unwrap();
    // Across the sleeve, at 0.2 s.
    let scene = r#"{"format": "gimage-scene", "version": 1, "duration": 0.5,
        "cloths": [{"from": {"garment": {"file": "sleeve.glb", "texels": 600}}, "position": [0, 0.5, 0],
            "pins": [{"select": {"box": {"low": [0.1, 1, -1], "high": [0.205, 3, 1]}}}]}],
        "cuts": [{"time": 0.2, "eye": [0.35, 1, 3], "a": [0.35, -9, -3], "b": [0.35, 15, -3]}]}"#;
    fs::write(place.path("cut.json"), scene).unwrap();
    let flags = "--backend cpu --frames 30 --every 5 --json";
    let run = place.run(&format!("export cut.json -o a.obj --surface render {flags}")).expect(&[0, 1]).json();
    assert_eq!(run["surface"].as_str(), Some("render"));
    let frame =
        |name: &str, k: usize| obj_corners(&fs::read_to_string(place.path(&format!("{name}_{k:05}.obj"))).unwrap());
    let counts = [3, 4, 6].map(|k| frame("a", k).len());
    assert!(counts[1] < counts[0] && counts[1] > counts[0] / 2 && counts[2] == counts[1], "{counts:?}");
    // Nothing spans the cut once the free part has fallen, and each part has some triangles.
    let last = frame("a", 6);
    let longest = |t: &[[f32; 3]; 3]| {
        let side = |a: usize, b: usize| (0..3).map(|c| (t[a][c] - t[b][c]).powi(2)).sum::<f32>().sqrt();
        side(0, 1).max(side(1, 2)).max(side(2, 0))
    };
    let [first_longest, last_longest] =
        [&frame("a", 1), &last].map(|list| list.as_chunks::<3>().0.iter().map(longest).fold(0.0, f32::max));
    assert!(last_longest < 1.5 * first_longest, "{last_longest} m, {first_longest} m at rest");
    let height = |upper: bool| last.iter().filter(|p| (p[0] < 0.35) == upper).count();
    assert!(height(true) > 20 && height(false) > 20);
    // A .glb has the frames before and after the cut as meshes of their own.
    place.run(&format!("export cut.json -o a.glb --surface render {flags}")).expect(&[0, 1]);
    let file = gltf::Gltf::from_slice(&fs::read(place.path("a.glb")).unwrap()).unwrap();
    assert_eq!(file.document.meshes().count(), 2);
    // By default a scene file is its grid.
    let run = place.run(&format!("export cut.json -o b.obj {flags}")).expect(&[0, 1]).json();
    assert_eq!(run["surface"].as_str(), Some("grid"));
    // A picture has it too.
    let flags = "--backend cpu --size 64x64 --json";
    let run = place.run(&format!("render cut.json -o a.png --surface render {flags}")).expect(&[0, 1]).json();
    assert_eq!(run["surface"].as_str(), Some("render"));
}

#[test]
fn compressed_files_have_the_same_motion_and_are_smaller() {
    let (place, expected) = simulated();
    place.run(&format!("export tube.gim -o plain.glb {FLAGS}")).expect(&[0, 1]);
    let size = |name: &str| fs::metadata(place.path(name)).unwrap().len();
    let largest = expected.iter().flatten().flatten().fold(0.0f32, |m, x| m.max(x.abs()));
    for (name, flags, most) in [
        ("m.glb", "--compress meshopt", largest / 131_072.0),
        ("f.glb", "--as meshes --compress meshopt", largest / 131_072.0),
        ("d.glb", "--as meshes --compress draco", 2.0 * largest / 65_536.0),
    ] {
        place.run(&format!("export tube.gim -o {name} {flags} {FLAGS}")).expect(&[0, 1]);
        assert!(size(name) < size("plain.glb") * 3 / 4, "{name}: {} bytes of {}", size(name), size("plain.glb"));
        // The importer of the builds reads the first frame.
        let read = gimage::import::import(&place.path(name), &gimage::import::ImportOptions::default()).unwrap().mesh;
        let frames = if name == "m.glb" { 1 } else { expected.len() };
        assert_eq!(read.triangles.len(), frames * expected[0].len() / 3, "{name}");
        // Encoders order triangles: the points of the first frame are those of the run.
        let near = |p: &[f32; 3]| {
            let gap = |q: &[f64; 3]| (0..3).map(|c| (q[c] - f64::from(p[c])).abs()).fold(0.0, f64::max);
            read.positions.iter().map(gap).fold(f64::INFINITY, f64::min)
        };
        let far = expected[0].iter().map(near).fold(0.0, f64::max);
        assert!(far <= f64::from(most), "{name}: {far} m, {most} asked for");
    }
    for (args, words) in
        [("-o x.glb --compress draco", "--as meshes"), ("-o x.usda --compress meshopt", "only a .glb has --compress")]
    {
        let run = place.run(&format!("export tube.gim {args} {FLAGS}")).expect(&[2]);
        assert!(run.stderr.contains(words), "{}", run.stderr);
    }
}
