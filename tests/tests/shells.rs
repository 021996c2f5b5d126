//! Garments modelled with a thickness build to single layers: a sample garment made solid, and real ones.

use std::collections::BTreeMap;

use gimage::closest::Closest;
use gimage::contents::{Kind, list};
use gimage::options::BuildOptions;
use gimage::shell::Layer;
use gimage::{Mesh, import, repair};
use gimage_runtime::Cloth;
use gimage_runtime::crossings::{self, Drawn};
use gimage_tests::{Shape, asset, build, build_shape, check, garments_or_skip, surface, texels};

/// The T-shirt of the samples.
fn shirt() -> Mesh {
    let mesh = import::import(&asset("tshirt.glb"), &import::ImportOptions::default()).unwrap().mesh;
    repair::repair(mesh, &repair::RepairOptions::default()).unwrap().mesh
}

fn plus(a: [f64; 3], b: [f64; 3], s: f64) -> [f64; 3] {
    std::array::from_fn(|k| a[k] + s * b[k])
}

/// Normals at the vertices, weighted by area.
fn normals(mesh: &Mesh) -> Vec<[f64; 3]> {
    let mut out = vec![[0.0; 3]; mesh.positions.len()];
    for (t, v) in mesh.triangles.iter().enumerate() {
        let [a, b, c] = mesh.corners(t);
        let (x, y) = (plus(b, a, -1.0), plus(c, a, -1.0));
        let n = [x[1] * y[2] - x[2] * y[1], x[2] * y[0] - x[0] * y[2], x[0] * y[1] - x[1] * y[0]];
        v.iter().for_each(|&v| out[v as usize] = plus(out[v as usize], n, 1.0));
    }
    out.into_iter().map(|n| n.map(|x| x / n.iter().map(|x| x * x).sum::<f64>().sqrt())).collect()
}

/// A mesh with a thickness: itself as the outer sheet, an inner sheet of four triangles for each of its own, and a rim.
fn solid(mesh: &Mesh, thickness: f64) -> Shape {
    let inwards = normals(mesh);
    let n = mesh.positions.len() as u32;
    let mut positions = mesh.positions.clone();
    positions.extend((0..mesh.positions.len()).map(|v| plus(mesh.positions[v], inwards[v], -thickness)));
    let mut middle: BTreeMap<[u32; 2], u32> = BTreeMap::new();
    let mut count: BTreeMap<[u32; 2], u32> = BTreeMap::new();
    let mut triangles = mesh.triangles.clone();
    for t in &mesh.triangles {
        let mut between = |a: u32, b: u32| {
            let edge = [a.min(b), a.max(b)];
            *count.entry(edge).or_default() += 1;
            *middle.entry(edge).or_insert_with(|| {
                let (p, q) = (positions[(a + n) as usize], positions[(b + n) as usize]);
                positions.push(std::array::from_fn(|k| 0.5 * (p[k] + q[k])));
                positions.len() as u32 - 1
            })
        };
        let [a, b, c] = *t;
        let (d, e, f) = (between(a, b), between(b, c), between(c, a));
        let [a, b, c] = [a + n, b + n, c + n];
        triangles.extend([[a, f, d], [d, e, b], [f, c, e], [d, f, e]]);
    }
    for t in &mesh.triangles {
        for [a, b] in [[t[0], t[1]], [t[1], t[2]], [t[2], t[0]]] {
            let edge = [a.min(b), a.max(b)];
            if count[&edge] == 1 {
                let m = middle[&edge];
                triangles.extend([[b, a, m], [a, a + n, m], [b, m, b + n]]);
            }
        }
    }
    Shape { positions, triangles }
}

fn keeping() -> BuildOptions {
    let mut options = texels(4096);
    options.shell.shell = Layer::Keep;
    options
}

#[test]
fn a_solid_shirt_builds_as_the_shirt_it_was_made_from() {
    let shirt = shirt();
    let thickness = 0.002;
    let shape = solid(&shirt, thickness);
    let built = build_shape(&shape, &texels(4096)).unwrap();
    check("solid shirt", &built);
    let piece = &built.bundle.manifest.pieces[0];
    assert_eq!(built.bundle.manifest.pieces.len(), 1);
    let own = piece.surface.as_ref().unwrap();
    assert_eq!((own.loops, own.triangles as usize), (4, shirt.triangles.len()));
    let shell = piece.shell.as_ref().unwrap();
    assert!((shell.thickness - thickness).abs() < 2e-4 && shell.share > 0.9 && shell.layer == "mid", "{shell:?}");
    assert_eq!((shell.bound_triangles + own.triangles) as usize, shape.triangles.len());
    // Every vertex of the image lies halfway, but for the error of the image.
    let outer = Closest::new(&shirt.positions, &shirt.triangles);
    let image = surface(&built.bundle);
    let depth = |p: &[f32; 3]| outer.project(p.map(f64::from)).unwrap().distance;
    let mut depths: Vec<f64> = image.positions.iter().map(depth).collect();
    depths.sort_by(f64::total_cmp);
    let median = depths[depths.len() / 2];
    assert!((median - 0.5 * thickness).abs() < 0.1 * thickness, "{median}");
    let kept = build_shape(&shape, &keeping()).unwrap();
    let folds = |m: &gimage_bundle::manifest::Manifest| m.quality.fold_area.unwrap();
    let (one, two) = (folds(&built.bundle.manifest), folds(&kept.bundle.manifest));
    println!("folded: {one} with one layer, {two} with both");
    assert!(one < 0.002 && two > 20.0 * one, "{one} {two}");
    // It goes into contact.
    let cloth = Cloth::from_bundle("shirt", &built.bundle).unwrap();
    assert_eq!(cloth.thickness, Some(0.5 * shell.thickness as f32));
    assert_eq!(Cloth::from_bundle("shirt", &kept.bundle).unwrap().thickness, None);
}

#[test]
fn a_solid_builds_to_the_same_bytes_with_any_number_of_threads() {
    let shape = solid(&shirt(), 0.003);
    let bytes = |threads: usize| {
        let pool = rayon::ThreadPoolBuilder::new().num_threads(threads).build().unwrap();
        pool.install(|| build_shape(&shape, &texels(1024)).unwrap().bundle.encode().unwrap())
    };
    assert!(bytes(1) == bytes(3));
}

#[test]
fn single_layers_build_alike_whatever_the_option() {
    for name in ["tshirt.glb", "cape.glb"] {
        let (one, two) = (build(&asset(name), &texels(1024)).unwrap(), {
            let mut options = texels(1024);
            options.shell.shell = Layer::Keep;
            build(&asset(name), &options).unwrap()
        });
        assert!(one.bundle.images == two.bundle.images, "{name}");
        let (mut a, b) = (one.bundle.manifest, two.bundle.manifest);
        a.options.insert("shell".into(), "keep".into());
        assert!(a == b, "{name}");
    }
}

#[test]
fn real_garments_with_a_thickness_come_out_as_clean_single_layers() {
    let test = "real_garments_with_a_thickness_come_out_as_clean_single_layers";
    let Some(folder) = garments_or_skip(test) else { return };
    // File, pieces, largest share that is folded, most crossings: with both sheets 0.42 and 0.09, 48,686 and 14,014.
    for (file, shells, fold, most) in [("dress_summer.glb", 4, 0.005, 1000), ("jacket_fleece.glb", 10, 0.01, 4000)] {
        let built = build(&folder.join(file), &texels(16_384)).unwrap();
        check(file, &built);
        let m = &built.bundle.manifest;
        let found: Vec<_> = m.pieces.iter().filter(|p| p.shell.is_some()).collect();
        assert_eq!((found.len(), m.pieces.len()), (shells, shells), "{file}");
        assert!(found.iter().all(|p| p.surface.as_ref().unwrap().loops == 1), "{file}");
        let cloth = Cloth::from_bundle(file, &built.bundle).unwrap();
        let crossing = crossings::find(&[Drawn::new(&cloth)], 1).unwrap().within;
        println!("{file}: {:?} folded, {crossing} pairs cross", m.quality.fold_area);
        assert!(
            m.quality.fold_area.unwrap() < fold && crossing < most,
            "{file}: {crossing}, {:?}",
            m.quality.fold_area
        );
        let listed = list(&folder.join(file), &BuildOptions::default()).unwrap();
        let thin: Vec<_> = listed.components.iter().filter(|c| c.kind == Kind::ThinShell).collect();
        assert_eq!(thin.len(), shells, "{file}");
        assert!(thin.iter().all(|c| c.loops.len() == 1 && c.loops[0].pin.is_some()), "{file}");
    }
}
