//! `gimage render`, and the scenes in assets/scenes in both commands.

use std::path::{Path, PathBuf};

use crate::common::{Place, list};
use crate::skip;
use image::{AnimationDecoder, ImageReader, RgbImage};

fn scenes() -> PathBuf {
    Path::new(env!("CARGO_MANIFEST_DIR")).join("../../assets/scenes")
}

fn picture(path: &Path) -> RgbImage {
    ImageReader::open(path).unwrap().decode().unwrap().to_rgb8()
}

/// Share of the pixels that differ from the one in the corner.
fn drawn(picture: &RgbImage) -> f64 {
    let corner = *picture.get_pixel(0, 0);
    let other = picture.pixels().filter(|p| **p != corner).count();
    other as f64 / f64::from(picture.width() * picture.height())
}

#[test]
fn every_scene_here_runs_and_is_drawn() {
    let place = Place::new();
    let names: Vec<_> = list(&scenes()).into_iter().filter(|n| n.ends_with(".json")).collect();
    assert!(names.len() >= 5, "{names:?}");
    for name in names {
        let scene = scenes().join(&name);
        let scene = scene.display();
        let run = place.run(&format!("simulate {scene} --backend cpu --frames 30 --substeps 4 --json")).expect(&[0]);
        assert_eq!(run.json()["frames"], 30, "{name}");
        assert_eq!(run.json()["substeps"], 4, "{name}");
        let flags = "--backend cpu --time 0.5 --substeps 4 --size 96x72 --json -o";
        let run = place.run(&format!("render {scene} {flags} {name}.png")).expect(&[0]);
        assert_eq!(run.json()["pictures"], 1, "{name}");
        let share = drawn(&picture(&place.path(&format!("{name}.png"))));
        assert!((0.05..=1.0).contains(&share), "{name}: {share}");
    }
}

#[test]
fn both_painters_agree() {
    let place = Place::new();
    // As the sheet meets the ball: later rounding decides how it folds, and the backends part.
    let flags = "s2 --n 24 --substeps 8 --time 0.3 --size 120x90 --background 102030";
    place.run(&format!("render {flags} --backend cpu -o cpu.png")).expect(&[0]);
    let gpu = place.run(&format!("render {flags} --backend gpu -o gpu.png"));
    if gpu.code != 0 {
        let required = std::env::var("GIMAGE_REQUIRE_GPU").is_ok_and(|v| v == "1");
        assert!(!required && gpu.stderr.contains("install"), "{}", gpu.stderr);
        skip::skip(gpu.stderr.trim());
        return;
    }
    let (a, b) = (picture(&place.path("cpu.png")), picture(&place.path("gpu.png")));
    assert_eq!(a.get_pixel(0, 0).0, [0x10, 0x20, 0x30]);
    let far = |(a, b): (&image::Rgb<u8>, &image::Rgb<u8>)| (0..3).map(|c| a[c].abs_diff(b[c])).max().unwrap();
    let differences: Vec<_> = a.pixels().zip(b.pixels()).map(far).collect();
    let mean = differences.iter().map(|d| f64::from(*d)).sum::<f64>() / differences.len() as f64;
    // Edges are sampled at other points; the rest is the same.
    let large = differences.iter().filter(|d| **d > 8).count() as f64 / differences.len() as f64;
    eprintln!("mean difference {mean} of 255, {large} of the pixels by more than 8");
    assert!(mean < 0.5 && large < 0.02, "mean {mean}, {large} of the pixels");
    assert!(drawn(&a) > 0.1);
}

#[test]
fn a_gif_has_the_pictures_asked_for_whatever_the_threads() {
    let place = Place::new();
    let flags = "s1 --n 9 --backend cpu --size 40x30 --time 0.5 --frames 4 --fps 10";
    place.run(&format!("render {flags} --threads 1 -o one.gif")).expect(&[0]);
    place.run(&format!("render {flags} --threads 2 -o two.gif")).expect(&[0]);
    let bytes = std::fs::read(place.path("one.gif")).unwrap();
    assert!(bytes == std::fs::read(place.path("two.gif")).unwrap());
    let decoder = image::codecs::gif::GifDecoder::new(std::io::Cursor::new(bytes)).unwrap();
    let frames = decoder.into_frames().collect_frames().unwrap();
    assert_eq!(frames.len(), 4);
    assert!(frames.iter().all(|f| f.buffer().dimensions() == (40, 30)));
    assert!(frames[0].buffer() != frames[3].buffer());
    assert_eq!(place.list(), ["one.gif", "tube.obj", "two.gif"]);
}

#[test]
fn a_bundle_is_framed_by_itself() {
    let place = Place::new();
    place.built("");
    place.run("render tube.gim -o tube.png --time 0 --size 100x100 --backend cpu").expect(&[0]);
    let picture = picture(&place.path("tube.png"));
    let share = drawn(&picture);
    assert!((0.3..0.95).contains(&share), "{share}");
    let edge = (0..100).flat_map(|k| [(k, 0), (k, 99), (0, k), (99, k)]);
    let corner = *picture.get_pixel(0, 0);
    assert!(edge.into_iter().all(|(x, y)| *picture.get_pixel(x, y) == corner), "it touches the edge");
}

#[test]
fn a_still_picture_of_a_bundle_without_pins_is_its_rest_pose() {
    let place = Place::new();
    place.built("");
    let flags = "--size 60x60 --backend cpu";
    let run = place.run(&format!("render tube.gim -o rest.png {flags} --json")).expect(&[0]);
    assert!(run.stderr.contains("rest pose") && run.stderr.contains("--time"), "{}", run.stderr);
    assert_eq!(run.json()["time"].as_f64(), Some(0.0));
    place.run(&format!("render tube.gim -o start.png {flags} --time 0")).expect(&[0]);
    assert!(std::fs::read(place.path("rest.png")).unwrap() == std::fs::read(place.path("start.png")).unwrap());
    // With pins it hangs, and the picture is that of the end.
    place.run("build tube.obj -o pinned.gim --texels 600 --pin above:0.75").expect(&[0, 1]);
    let run = place.run(&format!("render pinned.gim -o pinned.png {flags} --json")).expect(&[0]);
    assert!(run.json()["time"].as_f64().is_some_and(|t| t > 1.0) && !run.stderr.contains("rest pose"));
}

#[test]
fn what_cannot_be_drawn_is_said_and_leaves_nothing() {
    let place = Place::new();
    place.write("there.png", "not to be replaced");
    place.write("bad.json", "{\"format\": \"gimage-scene\", \"version\": 1, \"cloths\": [{\"form\": 1}]}");
    place.write("lost.json", r#"{"format": "gimage-scene", "version": 1, "cloths": [{"from": {"bundle": "no.gim"}}]}"#);
    let before = place.list();
    for (args, words) in [
        ("render s1 -o x.jpg", ".png"),
        ("render s1 -o none/x.png", "make the directory"),
        ("render s1 -o there.png", "there.png"),
        ("render s9 -o x.png", "s2f"),
        ("render s1 -o x.png --size 0x10", "--size"),
        ("render s1 -o x.png --size 99999x99999", "8192"),
        ("render s1 -o x.png --frames 2", ".gif"),
        ("render s1 -o x.png --time 1e9", "at most 86400 s"),
        ("render s1 -o x.gif --time 3000", "pictures"),
        ("render s1 -o x.png --camera 0,0,0,0,0,0", "camera"),
        ("render s1 -o x.png --camera 1,2", "six numbers"),
        ("render s1 -o x.png --background red", "hexadecimal"),
        ("render s1 -o x.png --fov 500", "angle"),
        ("render bad.json -o x.png", "bad.json: cloths[0].form: unknown field"),
        ("simulate bad.json", "bad.json: cloths[0].form: unknown field"),
        ("render lost.json -o x.png", "no.gim"),
        ("render tube.obj -o x.png", "gimage build"),
    ] {
        let run = place.run(args).expect(&[2]);
        assert!(run.stderr.contains(words), "{args}: {}", run.stderr);
    }
    assert_eq!(place.list(), before);
    assert_eq!(std::fs::read(place.path("there.png")).unwrap(), b"not to be replaced");
}

/// A bundle of a square with a texture in halves of red and green, if `image` is none.
fn textured(place: &Place, image: Option<&[u8]>) {
    let mut png = std::io::Cursor::new(Vec::new());
    let half = |x: u32, _| image::Rgb(if x < 8 { [250, 0, 0] } else { [0, 250, 0] });
    RgbImage::from_fn(16, 16, half).write_to(&mut png, image::ImageFormat::Png).unwrap();
    let image = image.unwrap_or(png.get_ref());
    let (mut bin, mut indices) = (Vec::new(), Vec::new());
    let side = 9u16;
    let unit = |k: u16| f32::from(k) / f32::from(side - 1);
    let all: Vec<(f32, f32)> = (0..side * side).map(|k| (unit(k % side), unit(k / side))).collect();
    all.iter().for_each(|(x, y)| [*x, *y, 0.0].iter().for_each(|v: &f32| bin.extend(v.to_le_bytes())));
    all.iter().for_each(|(x, y)| [*x, 1.0 - *y].iter().for_each(|v: &f32| bin.extend(v.to_le_bytes())));
    for k in (0..side * (side - 1)).filter(|k| k % side + 1 < side) {
        indices.extend([k, k + 1, k + side + 1, k, k + side + 1, k + side]);
    }
    let from = bin.len();
    indices.iter().for_each(|k: &u16| bin.extend(k.to_le_bytes()));
    let picture = bin.len();
    bin.extend(image);
    let count = all.len();
    let gltf = serde_json::json!({
        "asset": {"version": "2.0"}, "scene": 0, "scenes": [{"nodes": [0]}], "nodes": [{"name": "flag", "mesh": 0}],
        "meshes": [{"primitives": [{"attributes": {"POSITION": 0, "TEXCOORD_0": 1}, "indices": 2, "material": 0}]}],
        "materials": [{"name": "cloth", "pbrMetallicRoughness": {"baseColorTexture": {"index": 0}, "baseColorFactor": [1, 1, 1, 1]}}],
        "textures": [{"source": 0}], "images": [{"name": "halves", "bufferView": 3, "mimeType": "image/png"}],
        "buffers": [{"byteLength": bin.len(), "uri": "flag.bin"}],
        "bufferViews": [{"buffer": 0, "byteLength": 12 * count}, {"buffer": 0, "byteOffset": 12 * count, "byteLength": 8 * count},
            {"buffer": 0, "byteOffset": from, "byteLength": 2 * indices.len()}, {"buffer": 0, "byteOffset": picture, "byteLength": image.len()}],
        "accessors": [{"bufferView": 0, "componentType": 5126, "count": count, "type": "VEC3", "min": [0, 0, 0], "max": [1, 1, 0]},
            {"bufferView": 1, "componentType": 5126, "count": count, "type": "VEC2"},
            {"bufferView": 2, "componentType": 5123, "count": indices.len(), "type": "SCALAR"}]
    });
    std::fs::write(place.path("flag.bin"), bin).unwrap();
    place.write("flag.gltf", &gltf.to_string());
    place.run("build flag.gltf -o flag.gim --texels 400 --force").expect(&[0, 1]);
}

const FLAG: &str = "--time 0 --size 64x64 --backend cpu --camera 0.5,0.5,2,0.5,0.5,0 --json --force";

#[test]
fn the_mesh_of_a_bundle_is_drawn_with_its_texture() {
    let place = Place::new();
    textured(&place, None);
    let run = place.run(&format!("render flag.gim -o a.png {FLAG}")).expect(&[0]);
    assert_eq!((run.json()["surface"].as_str(), run.json()["ground"].is_null()), (Some("render"), true));
    let drawn = picture(&place.path("a.png"));
    let (left, right) = (drawn.get_pixel(24, 32).0, drawn.get_pixel(40, 32).0);
    assert!(left[0] > 150 && left[1] < 60 && right[1] > 150 && right[0] < 60, "{left:?} {right:?}");
    let run = place.run(&format!("render flag.gim -o b.png --surface grid --ground on {FLAG}")).expect(&[0]);
    assert_eq!(run.json()["surface"].as_str(), Some("grid"));
    assert!(run.json()["ground"]["height"].is_number());
}

#[test]
fn a_textured_mesh_is_drawn_alike_on_the_gpu_and_its_sampler_is_read() {
    let place = Place::new();
    textured(&place, None);
    // The same flag, whose texture coordinates go on to 3, with a sampler.
    let gltf = std::fs::read_to_string(place.path("flag.gltf")).unwrap();
    let mut gltf: serde_json::Value = serde_json::from_str(&gltf).unwrap();
    let transform = serde_json::json!({"KHR_texture_transform": {"scale": [3, 1]}});
    gltf["materials"][0]["pbrMetallicRoughness"]["baseColorTexture"]["extensions"] = transform;
    gltf["extensionsUsed"] = serde_json::json!(["KHR_texture_transform"]);
    gltf["textures"][0]["sampler"] = 0.into();
    let mut pictures = Vec::new();
    for wrap in [10_497, 33_071, 33_648] {
        gltf["samplers"] = serde_json::json!([{"wrapS": wrap}]);
        place.write("wrapped.gltf", &gltf.to_string());
        place.run("build wrapped.gltf -o wrapped.gim --texels 400 --force").expect(&[0, 1]);
        place.run(&format!("render wrapped.gim -o cpu.png {FLAG}")).expect(&[0]);
        pictures.push(picture(&place.path("cpu.png")));
        let gpu = place.run(&format!("render wrapped.gim -o gpu.png {}", FLAG.replace("backend cpu", "backend gpu")));
        if gpu.code != 0 {
            let required = std::env::var("GIMAGE_REQUIRE_GPU").is_ok_and(|v| v == "1");
            assert!(!required && gpu.stderr.contains("install"), "{}", gpu.stderr);
            skip::skip(gpu.stderr.trim());
            continue;
        }
        let (a, b) = (pictures.last().unwrap(), picture(&place.path("gpu.png")));
        let far = |(a, b): (&image::Rgb<u8>, &image::Rgb<u8>)| (0..3).map(|c| a[c].abs_diff(b[c])).max().unwrap();
        let mean = a.pixels().zip(b.pixels()).map(far).map(f64::from).sum::<f64>() / f64::from(64 * 64);
        assert!(mean < 2.0, "{wrap}: {mean}");
    }
    let red = |k: usize, x: u32| pictures[k].get_pixel(x, 32).0[0] > 128;
    // At 0.25, 0.75, 1.25, ..., 2.75 of the texture.
    let at = |k: usize| [11, 19, 28, 36, 45, 53].map(|x| red(k, x));
    assert_eq!(at(0), [true, false, true, false, true, false], "repeated");
    assert_eq!(at(1), [true, false, false, false, false, false], "held");
    assert_eq!(at(2), [true, false, false, true, true, false], "mirrored");
}

#[test]
fn a_picture_without_a_camera_has_all_parts_of_the_file_and_little_else() {
    let place = Place::new();
    textured(&place, None);
    // A second square that is left out, 3 m below the first.
    let gltf = std::fs::read_to_string(place.path("flag.gltf")).unwrap();
    let mut gltf: serde_json::Value = serde_json::from_str(&gltf).unwrap();
    gltf["nodes"] =
        serde_json::json!([{"name": "flag", "mesh": 0}, {"name": "post", "mesh": 0, "translation": [0, -3, 0]}]);
    gltf["scenes"] = serde_json::json!([{"nodes": [0, 1]}]);
    place.write("post.gltf", &gltf.to_string());
    place.run("build post.gltf -o post.gim --texels 400 --rigid post").expect(&[0, 1]);
    let rows = |surface: &str| {
        let args =
            format!("render post.gim -o a.png --time 0 --size 64x64 --backend cpu --surface {surface} --json --force");
        place.run(&args).expect(&[0]);
        let seen = picture(&place.path("a.png"));
        let paper = *seen.get_pixel(0, 0);
        let drawn = |y: &u32| (0..64).any(|x| *seen.get_pixel(x, *y) != paper);
        (0..64).filter(drawn).collect::<Vec<_>>()
    };
    let (all, flag) = (rows("render"), rows("grid"));
    // Both squares and the gap between them; the flag alone is as large as the picture.
    assert!((1..6).contains(&all[0]) && (58..63).contains(all.last().unwrap()) && all.len() < 45, "{all:?}");
    assert!((1..6).contains(&flag[0]) && (58..63).contains(flag.last().unwrap()) && flag.len() > 50, "{flag:?}");
}

#[test]
fn a_bundle_without_a_mesh_is_drawn_as_its_grid_and_says_so() {
    let place = Place::new();
    textured(&place, None);
    place.run("build flag.gltf -o bare.gim --texels 400 --render-mesh off").expect(&[0, 1]);
    let run = place.run(&format!("render bare.gim -o a.png {FLAG}")).expect(&[0]);
    assert!(run.stderr.contains("no render.glb") && run.stderr.contains("the grid is shown"), "{}", run.stderr);
    assert_eq!(run.json()["surface"].as_str(), Some("grid"));
    let run = place.run(&format!("render bare.gim -o b.png --surface render {FLAG}")).expect(&[2]);
    assert!(run.stderr.contains("--render-mesh on"), "{}", run.stderr);
}

#[test]
fn a_broken_texture_is_named_and_the_rest_is_drawn() {
    let place = Place::new();
    textured(&place, Some(b"\x89PNG\r\n\x1a\nbroken"));
    let run = place.run(&format!("render flag.gim -o a.png {FLAG}")).expect(&[0]);
    assert!(run.stderr.contains("texture 'halves'"), "{}", run.stderr);
    assert!(drawn(&picture(&place.path("a.png"))) > 0.1);
}
