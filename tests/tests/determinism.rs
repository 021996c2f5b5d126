//! The same input and options give the same bytes; what should not matter to the result matters little.

use std::path::Path;

use gimage::import::{ImportOptions, import};
use gimage::options::BuildOptions;
use gimage::pipeline::Built;
use gimage_bundle::MapKind;
use gimage_tests::shapes::{Random, Shape};
use gimage_tests::{asset, build, build_shape, check, garments_or_skip, pinned, point, psnr, texels, texels_of};

fn with_threads(threads: usize, path: &Path, options: &BuildOptions) -> Built {
    let pool = rayon::ThreadPoolBuilder::new().num_threads(threads).build().unwrap();
    pool.install(|| build(path, options)).unwrap()
}

/// Differing files by name; empty where both bundles are the same bytes.
fn differences(a: &Built, b: &Built) -> Vec<String> {
    let (a, b) = (a.bundle.encode().unwrap(), b.bundle.encode().unwrap());
    assert!(a.keys().eq(b.keys()));
    a.iter().filter(|(name, bytes)| b[*name] != **bytes).map(|(name, _)| name.clone()).collect()
}

#[test]
fn the_bytes_do_not_depend_on_the_threads() {
    let held = pinned(2000, &["above:1.4", "loop:0"]);
    for (name, options) in [("tshirt.glb", held), ("trousers.glb", point(3000)), ("dress.glb", texels(1500))] {
        let one = with_threads(1, &asset(name), &options);
        for threads in [1, 2, 5] {
            let other = with_threads(threads, &asset(name), &options);
            assert_eq!(differences(&one, &other), Vec::<String>::new(), "{name} with {threads} threads");
            assert_eq!(one.report.findings, other.report.findings);
        }
    }
}

#[test]
fn several_pieces_do_not_depend_on_the_threads() {
    let mut random = Random(11);
    let mut all = Shape::default();
    for k in 0..4 {
        let blob = gimage_tests::shapes::voxels(&gimage_tests::shapes::growth(4, 5 + 6 * k, &mut random), &mut random);
        let base = all.positions.len() as u32;
        all.positions.extend(blob.positions.iter().map(|p| [p[0] + 9.0 * k as f64, p[1], p[2]]));
        all.triangles.extend(blob.triangles.iter().map(|t| t.map(|v| v + base)));
    }
    let folder = tempfile::tempdir().unwrap();
    let path = folder.path().join("blobs.obj");
    std::fs::write(&path, all.obj()).unwrap();
    let one = with_threads(1, &path, &texels(4000));
    assert!(one.bundle.manifest.pieces.len() >= 4);
    for threads in [2, 5] {
        let other = with_threads(threads, &path, &texels(4000));
        assert_eq!(differences(&one, &other), Vec::<String>::new(), "{threads} threads");
    }
}

/// The positions of a file as a shape.
fn plain(path: &Path) -> Shape {
    let mesh = import(path, &ImportOptions::default()).unwrap().mesh;
    let mesh = gimage::repair::repair(mesh, &Default::default()).unwrap().mesh;
    Shape { positions: mesh.positions, triangles: mesh.triangles }
}

/// 20 log10 (`diagonal` / RMS) \[dB\]: a bounding box depends on how the shape is turned, so all share one.
fn quality(what: &str, shape: &Shape, diagonal: Option<f64>) -> (f64, f64) {
    let built = build_shape(shape, &point(3000)).unwrap();
    check(what, &built);
    let q = &built.bundle.manifest.quality;
    let diagonal = diagonal.unwrap_or(q.diagonal.unwrap());
    (20.0 * (diagonal / q.rms.unwrap()).log10(), diagonal)
}

/// Numbers, order and place of the input are not a part of the shape. Choices may fall differently where two are equally
/// good to rounding, so the result is not the same, but it is no worse to speak of.
#[test]
fn order_and_place_of_the_input_matter_little() {
    let mut random = Random(3);
    let turned = |p: [f64; 3]| {
        let (s, c) = 0.7f64.sin_cos();
        let q = [c * p[0] - s * p[1], s * p[0] + c * p[1], p[2]];
        [q[0], c * q[1] - s * q[2], s * q[1] + c * q[2]]
    };
    let mut wrong = Vec::new();
    let mut shapes: Vec<(String, Shape)> =
        ["tshirt.glb", "trousers.glb", "dress.glb"].map(|n| (n.to_owned(), plain(&asset(n)))).into();
    if let Some(folder) = garments_or_skip("order and place, on shared garments") {
        shapes.extend(["skirt_evening.obj", "models/spot.obj"].map(|n| (n.to_owned(), plain(&folder.join(n)))));
    }
    for (name, shape) in shapes {
        let (own, diagonal) = quality(&name, &shape, None);
        for (what, scale, other) in [
            ("shuffled", 1.0, shape.shuffled(&mut random)),
            ("turned", 1.0, shape.clone().moved(turned)),
            ("a thousand times as large", 1e3, shape.clone().moved(|p| p.map(|x| 1e3 * x))),
            ("a thousandth as large", 1e-3, shape.clone().moved(|p| p.map(|x| 1e-3 * x))),
            ("moved by metres", 1.0, shape.clone().moved(|p| [p[0] + 3.0, p[1] - 7.0, p[2] + 5.0])),
        ] {
            let (got, _) = quality(what, &other, Some(scale * diagonal));
            println!("{name} {what}: {got:.2} dB, as it is {own:.2} dB");
            if (got - own).abs() >= 0.1 {
                wrong.push(format!("{name} {what}: {got:.2} dB, as it is {own:.2} dB"));
            }
        }
    }
    assert!(wrong.is_empty(), "{}", wrong.join("\n"));
}

#[test]
fn the_unit_scales_lengths() {
    let options = point(1500);
    let unit = |unit: f64| {
        let import = ImportOptions { unit, ..ImportOptions::default() };
        build(&asset("tshirt.glb"), &BuildOptions { import, ..options.clone() }).unwrap()
    };
    // A power of two scales without rounding, so every choice falls the same way.
    let (one, quarter) = (unit(1.0), unit(0.25));
    check("a quarter", &quarter);
    let (a, b) = (texels_of(&one.bundle, 0), texels_of(&quarter.bundle, 0));
    assert_eq!(a.len(), b.len());
    for (p, q) in a.iter().zip(&b) {
        assert_eq!(p[3], q[3]);
        assert!((0..3).all(|c| (0.25 * p[c] - q[c]).abs() < 1e-6), "{p:?} {q:?}");
    }
    let rest = |built: &Built| built.bundle.image(0, &MapKind::Rest).unwrap().data.clone();
    for (x, y) in rest(&one).iter().zip(rest(&quarter)) {
        assert!((0.25 * x - y).abs() < 1e-6);
    }
    let area = |built: &Built| built.bundle.manifest.pieces[0].surface.as_ref().unwrap().area;
    assert!((area(&quarter) * 16.0 / area(&one) - 1.0).abs() < 1e-9);
    assert!((psnr(&one.bundle) - psnr(&quarter.bundle)).abs() < 0.01);
}
