//! The render mesh of a bundle: bound where the source has it, moved with the cloth, without cracks.

use std::path::Path;

use crate::drawn::{distance, no_crack, rest_error, source, stepper};

use gimage::options::BuildOptions;
use gimage::render::RenderMesh as Choice;
use gimage_bundle::{RENDER_FILE, surface_normals};
use gimage_runtime::RenderMesh;
use gimage_tests::shapes::{Random, sheet};
use gimage_tests::{asset, build, build_shape, check, garments_or_skip, pinned, reread, texels, texels_of};

#[test]
fn the_samples_are_where_their_files_have_them() {
    for (name, pin) in [
        ("tshirt.glb", "above:1.4"),
        ("dress.glb", "above:1.2"),
        ("skirt.glb", "loop:top"),
        ("trousers.glb", "loop:top"),
        ("cape.glb", "loop:top"),
        ("sleeve.glb", "loop:top"),
    ] {
        let built = build(&asset(name), &pinned(2048, &[pin])).unwrap();
        check(name, &built);
        let bundle = reread(&built.bundle);
        let entry = bundle.manifest.render.as_ref().unwrap();
        assert_eq!((entry.vertices, entry.bound > 0), (entry.bound, true), "{name}: every vertex is bound");
        let (position, normal) = rest_error(&bundle);
        println!("{name}: {position:.1e} of the diagonal, normals {normal:.1e}");
        assert!(position < 1e-6 && normal < 1e-4, "{name}: {position:e}, {normal:e}");
        // A simulated second.
        let mesh = RenderMesh::from_bundle(&bundle).unwrap().unwrap();
        let mut stepper = stepper(&bundle);
        (0..60).for_each(|_| _ = stepper.advance(1.0 / 60.0).unwrap());
        let mut vertices = Vec::new();
        stepper.wrap(0, &mesh, 1.0, &mut vertices).unwrap();
        let source = source(&bundle);
        no_crack(name, &source, &vertices, &mesh);
        let moved = source.iter().zip(&vertices).filter(|(s, v)| distance(s.0, &v.position) > 1e-4).count();
        assert!(10 * moved > source.len(), "{name}: {moved} of {} vertices moved", source.len());
        assert!(vertices.iter().flat_map(|v| v.position).all(f32::is_finite));
    }
}

#[test]
fn a_turned_cloth_turns_its_mesh() {
    let bundle = reread(&build(&asset("tshirt.glb"), &texels(2048)).unwrap().bundle);
    let mesh = RenderMesh::from_bundle(&bundle).unwrap().unwrap();
    let texels: Vec<[f32; 4]> = (0..bundle.manifest.pieces.len()).flat_map(|piece| texels_of(&bundle, piece)).collect();
    let normals: Vec<[f32; 4]> = surface_normals(&bundle).unwrap().iter().map(|[x, y, z]| [*x, *y, *z, 0.0]).collect();
    // Quarter turns are exact, so that only the mesh rounds.
    let turn = |[x, y, z, w]: [f32; 4]| [z, x, y, w];
    let (mut still, mut turned) = (Vec::new(), Vec::new());
    mesh.deform(&texels, &normals, &mut still).unwrap();
    let all = |list: &[[f32; 4]]| list.iter().map(|p| turn(*p)).collect::<Vec<_>>();
    mesh.deform(&all(&texels), &all(&normals), &mut turned).unwrap();
    for (a, b) in still.iter().zip(&turned) {
        for (a, b) in [(a.position, b.position), (a.normal, b.normal), (a.tangent, b.tangent)] {
            let gap = turn(a).iter().zip(b).map(|(a, b)| (a - b).abs()).fold(0.0, f32::max);
            assert!(gap < 1e-6, "{a:?} {b:?}");
        }
    }
}

#[test]
fn a_file_without_gltf_has_a_mesh_too_and_it_can_be_left_out() {
    let shape = sheet(14, 9, &mut Random(7), |u, v| [u, v, 0.1 * (5.0 * u).sin()]);
    let built = build_shape(&shape, &texels(1024)).unwrap();
    let (position, _) = rest_error(&reread(&built.bundle));
    assert!(position < 1e-6, "{position:e}");
    let mut options: BuildOptions = texels(1024);
    options.render.render_mesh = Choice::Off;
    let without = build_shape(&shape, &options).unwrap().bundle;
    assert!(without.render.is_none() && without.manifest.render.is_none());
    assert!(!without.encode().unwrap().contains_key(RENDER_FILE));
    assert_eq!(without.images, built.bundle.images);
    assert!(RenderMesh::from_bundle(&without).unwrap().is_none());
}

#[test]
fn an_obj_file_in_other_units_and_axes_has_its_mesh_where_its_cloth_is() {
    use std::fmt::Write;
    // A sheet in centimetres, z up.
    let n = 12;
    let mut text = "o Sheet\n".to_owned();
    for k in 0..n * n {
        let [u, v] = [k % n, k / n].map(|x| 80.0 * f64::from(x) / f64::from(n - 1));
        writeln!(text, "v {u} {} {v}", 5.0 * (u / 20.0).sin()).unwrap();
    }
    for k in (0..n * (n - 1)).filter(|k| k % n + 1 < n).map(|k| k + 1) {
        writeln!(text, "f {k} {} {} {}", k + 1, k + n + 1, k + n).unwrap();
    }
    let folder = tempfile::tempdir().unwrap();
    let path = folder.path().join("sheet.obj");
    std::fs::write(&path, text).unwrap();
    let mut options = texels(1024);
    options.import.unit = 0.01;
    options.import.up = gimage::import::Up::Z;
    let bundle = reread(&build(&path, &options).unwrap().bundle);
    let (position, normal) = rest_error(&bundle);
    assert!(position < 1e-6 && normal < 1e-4, "{position:e} {normal:e}");
    let highest = source(&bundle).iter().map(|s| s.0[1]).fold(f64::MIN, f64::max);
    assert!((highest - 0.8).abs() < 1e-6, "{highest}");
}

/// Files of the shared folder.
const GARMENTS: [&str; 12] = [
    "dress_belted_202k.glb",
    "skirt_evening.obj",
    "tshirt_1900.obj",
    "hat_fedora.obj",
    "suit_male06.obj",
    "jacket_fleece.glb",
    "dress_summer.glb",
    "outfit_skinned.glb",
    "mage_skinned.glb",
    "knight_skinned/scene.gltf",
    "compressed/polo_draco.glb",
    "compressed/shorts_meshopt.glb",
];

#[test]
fn real_garments_are_where_their_files_have_them() {
    let Some(folder) = garments_or_skip("real_garments_are_where_their_files_have_them") else { return };
    let mut wrong = Vec::new();
    for name in GARMENTS {
        let path: &Path = &folder.join(name);
        if !path.exists() {
            println!("{name} is not here");
            continue;
        }
        let mut options = texels(8192);
        options.gate.metrics = false;
        options.gate.accept_poor = true;
        let built = build(path, &options).unwrap_or_else(|e| panic!("{name}: {e}"));
        let bundle = reread(&built.bundle);
        let Some(entry) = &bundle.manifest.render else {
            wrong.push(format!("{name}: no render mesh"));
            continue;
        };
        let (position, normal) = rest_error(&bundle);
        println!(
            "{name}: {} of {} vertices bound, {position:.1e} of the diagonal, normals {normal:.1e}, largest offset {:.4} m",
            entry.bound, entry.vertices, entry.largest_offset
        );
        if position >= 1e-6 {
            wrong.push(format!("{name}: {position:e} of the diagonal"));
        }
    }
    assert!(wrong.is_empty(), "{wrong:?}");
}
