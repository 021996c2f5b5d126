//! Cloth that is drawn finer than its file has it: on the same surface, without cracks, as fine as its particles can show.

use std::collections::HashMap;
use std::path::Path;

use crate::drawn::{no_crack, rest_error, source, stepper};
use gimage::options::BuildOptions;
use gimage::pipeline::dress;
use gimage::progress::Quiet;
use gimage::render::Subdivision;
use gimage_bundle::{Bundle, RenderFile};
use gimage_runtime::RenderMesh;
use gimage_tests::shapes::{Random, sheet};
use gimage_tests::{asset, build, build_shape, garments_or_skip, pinned, reread, texels};

/// The triangles of the cloth of a bundle, by their corners in the source \[m\].
fn triangles(bundle: &Bundle) -> Vec<[[f64; 3]; 3]> {
    let at = source(bundle);
    let mut first = 0;
    let mut out = Vec::new();
    for p in RenderFile::parse(bundle.render.as_ref().unwrap()).unwrap().primitives().unwrap() {
        let corner = |v: u32| at[first + v as usize].0;
        let own = p.indices.as_chunks::<3>().0.iter().map(|t| t.map(corner));
        out.extend(own.filter(|_| !p.coords.is_empty()));
        first += p.positions.len();
    }
    out
}

fn length([a, b]: [[f64; 3]; 2]) -> f64 {
    (0..3).map(|k| (a[k] - b[k]).powi(2)).sum::<f64>().sqrt()
}

/// The length of all borders \[m\]: edges with one triangle. Half an edge on one side of it would be a border on both.
fn border(triangles: &[[[f64; 3]; 3]]) -> f64 {
    let bits = |p: [f64; 3]| p.map(|x| (x + 0.0).to_bits());
    let mut edges: HashMap<[[u64; 3]; 2], (usize, f64)> = HashMap::new();
    for t in triangles {
        for ends in [[t[0], t[1]], [t[1], t[2]], [t[2], t[0]]] {
            let mut key = ends.map(bits);
            key.sort_unstable();
            edges.entry(key).or_insert((0, length(ends))).0 += 1;
        }
    }
    edges.values().filter(|(count, _)| *count == 1).map(|(_, long)| long).sum()
}

fn area(triangles: &[[[f64; 3]; 3]]) -> f64 {
    let one = |[a, b, c]: &[[f64; 3]; 3]| {
        let [u, v] = [b, c].map(|p| [0, 1, 2].map(|k| p[k] - a[k]));
        let n = [0, 1, 2].map(|k| u[(k + 1) % 3] * v[(k + 2) % 3] - u[(k + 2) % 3] * v[(k + 1) % 3]);
        0.5 * n.iter().map(|x| x * x).sum::<f64>().sqrt()
    };
    triangles.iter().map(one).sum()
}

fn longest(triangles: &[[[f64; 3]; 3]]) -> f64 {
    triangles.iter().flat_map(|t| [[t[0], t[1]], [t[1], t[2]], [t[2], t[0]]]).map(length).fold(0.0, f64::max)
}

/// Checks a bundle that is drawn finer against one of the same options that is not; `cells` is the limit of its edges.
fn is_finer(name: &str, plain: &Bundle, fine: &Bundle, cells: f64) {
    assert_eq!(plain.images, fine.images, "{name}: the images do not depend on what is drawn");
    let (before, after) = (triangles(plain), triangles(fine));
    assert!(after.len() > before.len(), "{name}: {} triangles", after.len());
    let rows = |bundle: &Bundle| bundle.manifest.pieces.iter().map(|p| f64::from(p.width * p.height)).sum::<f64>();
    let (old, new) = (area(&before), area(&after));
    assert!((old - new).abs() < 1e-6 * old, "{name}: area {old} -> {new}");
    let (old, new) = (border(&before), border(&after));
    assert!((old - new).abs() < 1e-6 * old.max(1e-3), "{name}: borders of {old} -> {new} m");
    // A shell is drawn on both sides, so that its drawn area is up to twice that of its particles.
    let limit = cells * (area(&after) / rows(fine)).sqrt();
    let long = longest(&after);
    assert!(long < 1.3 * limit, "{name}: {long} m, of {limit}");
    let (position, _) = rest_error(fine);
    assert!(position < 1e-6, "{name}: {position:e} of the diagonal");
    let mesh = RenderMesh::from_bundle(fine).unwrap().unwrap();
    let mut stepper = stepper(fine);
    (0..30).for_each(|_| _ = stepper.advance(1.0 / 60.0).unwrap());
    let mut vertices = Vec::new();
    stepper.wrap(0, &mesh, 1.0, &mut vertices).unwrap();
    no_crack(name, &source(fine), &vertices, &mesh);
    println!(
        "{name}: {} -> {} triangles, longest edge {:.1} of {:.1} mm",
        before.len(),
        after.len(),
        1e3 * long,
        1e3 * limit
    );
}

fn with(options: &BuildOptions, cells: f64) -> BuildOptions {
    let mut options = options.clone();
    options.render.subdivide = Some(Subdivision::Cells(cells));
    options
}

#[test]
fn the_samples_are_drawn_as_finely_as_their_particles() {
    for (name, pin) in [("skirt.glb", "loop:top"), ("cape.glb", "loop:top"), ("tshirt.glb", "above:1.4")] {
        let options = pinned(12_000, &[pin]);
        let plain = reread(&build(&asset(name), &options).unwrap().bundle);
        let fine = build(&asset(name), &with(&options, 1.5)).unwrap();
        assert!(fine.report.findings.iter().any(|f| f.kind == "hint-subdivided"), "{name}");
        is_finer(name, &plain, &reread(&fine.bundle), 1.5);
    }
}

#[test]
fn a_mesh_of_another_format_is_drawn_finer_too() {
    let shape = sheet(5, 4, &mut Random(7), |u, v| [u, v, 0.1 * (5.0 * u).sin()]);
    let plain = reread(&build_shape(&shape, &texels(4096)).unwrap().bundle);
    let fine = reread(&build_shape(&shape, &with(&texels(4096), 4.0)).unwrap().bundle);
    is_finer("sheet", &plain, &fine, 4.0);
}

#[test]
fn fine_cloth_stays_as_it_is() {
    let options = pinned(2048, &["loop:top"]);
    let plain = build(&asset("skirt.glb"), &options).unwrap().bundle;
    let fine = build(&asset("skirt.glb"), &with(&options, 64.0)).unwrap();
    assert_eq!(plain.render, fine.bundle.render);
    assert!(!fine.report.findings.iter().any(|f| f.kind == "hint-subdivided"));
}

#[test]
fn dressed_characters_are_drawn_finer_unless_told() {
    let Some(folder) = garments_or_skip("dressed_characters_are_drawn_finer_unless_told") else { return };
    for name in ["mage_skinned.glb", "outfit_skinned.glb"] {
        let path: &Path = &folder.join(name);
        if !path.exists() {
            println!("{name} is not here");
            continue;
        }
        let mut options = texels(4096);
        options.gate.metrics = false;
        let made = |options: &BuildOptions| reread(&dress(path, options, &Default::default(), &Quiet).unwrap().bundle);
        let fine = made(&options);
        options.render.subdivide = Some(Subdivision::None);
        let plain = made(&options);
        let [old, new] = [&plain, &fine].map(|bundle| {
            let file = RenderFile::parse(bundle.render.as_ref().unwrap()).unwrap();
            file.primitives().unwrap().iter().map(|p| p.indices.len() / 3).sum::<usize>()
        });
        let (position, _) = rest_error(&fine);
        println!("{name}: {old} -> {new} triangles, {position:.1e} of the diagonal");
        assert!(new > old && position < 1e-6, "{name}: {old} -> {new}, {position:e}");
        assert_eq!(plain.images, fine.images);
    }
}
