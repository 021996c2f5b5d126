//! Surfaces that no single image holds: split into parts, welded, checked, simulated.

use std::collections::BTreeMap;

use gimage::options::BuildOptions;
use gimage::pipeline::Built;
use gimage::topology::Topology;
use gimage_bundle::{MapKind, validate};
use gimage_runtime::*;
use gimage_tests::shapes::{Random, Shape, sheet};
use gimage_tests::{build_shape, check, pinned, psnr, reread, surface, texels};

/// A flat sheet of 1 m of `n` x `n` quads without every second quad of every second row.
fn lace(n: usize) -> Shape {
    let mut shape = sheet(n, n, &mut Random(1), |u, v| [u, 1.0 + v, 0.0]);
    let inside = |t: &[u32; 3]| {
        let at = |c: usize| t.iter().map(|&v| shape.positions[v as usize][c]).sum::<f64>() / 3.0 - c as f64;
        let cell = |x: f64| (x * n as f64).floor() as usize;
        cell(at(0)) % 2 == 1 && cell(at(1)) % 2 == 1
    };
    shape.triangles = shape.triangles.iter().filter(|t| !inside(t)).copied().collect();
    shape
}

fn built(n: usize, options: &BuildOptions) -> Built {
    build_shape(&lace(n), options).unwrap()
}

#[test]
fn a_sheet_of_400_holes_is_split_into_parts_that_weld() {
    let built = built(41, &pinned(16_384, &["above:1.99"]));
    check("lace", &built);
    let manifest = &built.bundle.manifest;
    assert_eq!(manifest.components.len(), 1);
    let whole = &manifest.components[0];
    assert_eq!((whole.surface.euler, whole.surface.loops), (-399, 401));
    assert!(manifest.pieces.len() > 1);
    for (k, piece) in manifest.pieces.iter().enumerate() {
        assert_eq!((piece.part_of, &piece.name), (Some(0), &format!("{}.{}", whole.name, k + 1)));
    }
    let total: u32 = manifest.pieces.iter().map(|p| p.width * p.height).sum();
    assert!(total <= 16_384, "{total} texels");
    assert!(psnr(&built.bundle) > 60.0, "{} dB", psnr(&built.bundle));
    let t = Topology::of(&surface(&built.bundle).triangles);
    assert_eq!((t.euler, t.boundary_loops, t.components), (-399, 401, 1));
    assert!(t.is_oriented_manifold(), "{t:?}");
    assert!(built.report.findings.iter().any(|f| f.kind == "split"));
}

#[test]
fn the_masses_of_parts_add_to_area_times_density_and_tethers_cross_seams() {
    let bundle = reread(&built(21, &pinned(4096, &["above:1.99"])).bundle);
    assert!(bundle.manifest.pieces.len() > 1 && validate(&bundle).is_empty());
    let rings = bundle.rings().unwrap();
    assert!(rings.iter().any(|r| bundle.locate(r[0]).unwrap().0 != bundle.locate(r[r.len() - 1]).unwrap().0));
    let mut point: BTreeMap<u32, u32> = BTreeMap::new();
    point.extend(rings.iter().flat_map(|r| r.iter().map(|&k| (k, r[0]))));
    let mut mass = 0.0;
    for index in 0..bundle.manifest.texels() {
        let (piece, k) = bundle.locate(index).unwrap();
        if point.get(&index).is_none_or(|&first| first == index) {
            mass += f64::from(bundle.image(piece, &MapKind::Mass).unwrap().at(k)[0]);
        }
        // Every particle hangs from the pinned edge, by no more than the way around the holes and no less than the height.
        let tether = bundle.image(piece, &MapKind::Tether).unwrap().at(k);
        let y = bundle.position(index).unwrap()[1];
        assert!(
            tether[1] >= 0.0 && tether[0] >= 1.99 - y - 0.02 && tether[0] < 1.6 * (2.0 - y) + 0.2,
            "{tether:?} at {y}"
        );
    }
    let area = bundle.manifest.components[0].surface.area;
    assert!((mass / (area * 0.15) - 1.0).abs() < 1e-3, "{mass} kg for {area} m2");
}

#[test]
fn parts_agree_on_the_limits_of_the_points_that_they_share() {
    let mut options = texels(4096);
    options.assemble.limits =
        vec!["box:0,1,-1,0.6,1.5,1=0.1".parse().unwrap(), "box:0,1,-1,0.3,2,1=0.05".parse().unwrap()];
    let built = built(21, &options);
    // Part of that check: rings agree bit for bit.
    check("lace", &built);
    let (bundle, limits) = (reread(&built.bundle), built.bundle.limits().unwrap());
    let rings = bundle.rings().unwrap();
    let across = |r: &[u32]| bundle.locate(r[0]).unwrap().0 != bundle.locate(r[r.len() - 1]).unwrap().0;
    let held = rings.iter().filter(|r| across(r) && limits[r[0] as usize] > 0.0).count();
    let free = rings.iter().filter(|r| across(r) && limits[r[0] as usize] < 0.0).count();
    assert!(held > 4 && free > 4, "{held} rings across parts have a limit, {free} have none");
    assert_eq!(bundle.limits().unwrap(), limits);
}

#[test]
fn seams_between_parts_stay_closed_in_motion() {
    let built = built(21, &pinned(4096, &["above:1.99"]));
    let rings = built.bundle.rings().unwrap();
    let mut scene = Scene::new("lace");
    scene.cloths.push(Cloth::from_bundle("lace", &built.bundle).unwrap());
    let options = Options { backend: Backend::Cpu, ..Options::default() };
    let mut stepper = Stepper::new(scene, options, None).unwrap();
    for _ in 0..30 {
        stepper.advance(1.0 / 60.0).unwrap();
    }
    let positions = stepper.positions(0).unwrap();
    for ring in rings.iter() {
        let at = |k: u32| [0, 1, 2].map(|c| positions[k as usize][c].to_bits());
        assert!(ring.iter().all(|&k| at(k) == at(ring[0])), "a seam opened");
    }
    assert!(positions.iter().all(|p| p.iter().all(|x| x.is_finite())));
}
