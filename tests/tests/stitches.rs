//! Pieces that share no vertex are tied: a panel with a pocket, two panels with a seam, and real garments.

use gimage::options::BuildOptions;
use gimage::pipeline::Built;
use gimage::stitch::Stitching;
use gimage_bundle::{RenderFile, Stitch, validate};
use gimage_runtime::{Cloth, Options, RenderMesh, Scene, Stepper};
use gimage_tests::{Shape, build, build_shape, garments_or_skip, pinned, reread};

/// Adds an upright sheet of `n` x `n` quads: its corner, its sides \[m\], and how far to the front it bulges.
fn sheet(shape: &mut Shape, n: u32, corner: [f64; 3], sides: [f64; 2], bulge: f64) {
    let first = shape.positions.len() as u32;
    for (j, i) in (0..=n).flat_map(|j| (0..=n).map(move |i| (j, i))) {
        let [u, v] = [i, j].map(|k| f64::from(k) / f64::from(n));
        let z = corner[2] + bulge * (std::f64::consts::PI * u).sin() * (std::f64::consts::PI * v).sin();
        shape.positions.push([corner[0] + u * sides[0], corner[1] + v * sides[1], z]);
    }
    for (j, i) in (0..n).flat_map(|j| (0..n).map(move |i| (j, i))) {
        let k = first + j * (n + 1) + i;
        shape.triangles.extend([[k, k + 1, k + n + 2], [k, k + n + 2, k + n + 1]]);
    }
}

/// A panel of 1 m with a pocket 1 mm in front of it that bulges.
fn pocket() -> Shape {
    let mut shape = Shape::default();
    sheet(&mut shape, 12, [0.0; 3], [1.0, 1.0], 0.0);
    sheet(&mut shape, 7, [0.31, 0.22, 0.001], [0.36, 0.41], 0.03);
    shape
}

fn options(n: u32, stitch: Stitching) -> BuildOptions {
    let mut options = pinned(n, &["above:0.98"]);
    options.stitch.stitch = stitch;
    options
}

fn found<'a>(built: &'a Built, kind: &str) -> Option<&'a gimage::record::Finding> {
    built.report.findings.iter().find(|f| f.kind == kind)
}

#[test]
fn a_pocket_is_sewn_along_its_border_at_every_budget() {
    for n in [600, 1500, 6000] {
        let built = build_shape(&pocket(), &options(n, Stitching::Auto)).unwrap();
        let bundle = reread(&built.bundle);
        assert_eq!(validate(&bundle), []);
        let stitches = bundle.stitches();
        let pocket = &bundle.manifest.pieces[1];
        // Its border is sewn, all around; nothing inside of it, and nothing of the panel.
        for Stitch { particle, piece, distance, .. } in &stitches {
            let k = particle - pocket.first_particle;
            let (i, j) = (k % pocket.width, k / pocket.width);
            assert!(i == 0 || j == 0 || i == pocket.width - 1 || j == pocket.height - 1, "{n}: texel ({i}, {j})");
            assert_eq!(*piece, 0);
            assert!((*distance - 1e-3).abs() < 1e-3, "{n}: {distance} m");
        }
        let border = 2 * (pocket.width + pocket.height) as usize - 4;
        assert!(stitches.len() > border * 3 / 4, "{n}: {} of {border}", stitches.len());
        let note = found(&built, "stitched").unwrap();
        assert_eq!(note.count as usize, stitches.len());
        assert!(found(&built, "loose-piece").is_none());
        hangs_over_its_stitches(&built, pocket);
    }
}

/// Every particle of the pocket has a tether to a pin of the panel, as long as the way down the panel and over the border of the pocket.
fn hangs_over_its_stitches(built: &Built, pocket: &gimage_bundle::manifest::PieceEntry) {
    let stored = built.bundle.stored_tethers().unwrap();
    assert_eq!(stored, built.bundle.compute_tethers(1).unwrap());
    for k in pocket.first_particle..pocket.first_particle + pocket.width * pocket.height {
        let anchor = stored.of(k as usize)[0];
        assert!(anchor.exists() && anchor.particle < pocket.first_particle, "{k}: {anchor:?}");
        let [from, to] = [k, anchor.particle].map(|k| built.bundle.position(k).unwrap());
        let straight = (0..3).map(|c| f64::from(from[c] - to[c]).powi(2)).sum::<f64>().sqrt();
        let excess = f64::from(anchor.distance) - straight;
        // The pocket bulges by 3 cm, threads are 1 mm long, and a border of few texels is sewn with gaps.
        assert!((-1e-3..0.05).contains(&excess), "{k}: {} m for {straight}", anchor.distance);
    }
}

#[test]
fn backstops_are_built_from_expressions() {
    let mut build_options = options(1500, Stitching::Auto);
    build_options.assemble.backstops = ["below:0.5=0.02", "above:0.9=0.01,0.5"].map(|b| b.parse().unwrap()).to_vec();
    let bundle = reread(&build_shape(&pocket(), &build_options).unwrap().bundle);
    assert_eq!(validate(&bundle), []);
    let backstops = bundle.backstops().unwrap();
    let (mut low, mut high) = (0, 0);
    for (k, backstop) in (0u32..).zip(&backstops) {
        let y = bundle.position(k).unwrap()[1];
        let expected = if y < 0.5 {
            [0.02, 0.1]
        } else if y > 0.9 {
            [0.01, 0.5]
        } else {
            [-1.0, 0.0]
        };
        assert_eq!(*backstop, expected, "{k} at {y}");
        (low, high) = (low + u32::from(y < 0.5), high + u32::from(y > 0.9));
    }
    assert!(low > 300 && high > 50, "{low} {high}");
    let without = build_shape(&pocket(), &options(1500, Stitching::Auto)).unwrap();
    assert!(without.bundle.backstops().is_none() && !without.bundle.manifest.options.contains_key("backstop"));
    assert!(bundle.manifest.options.contains_key("backstop"));
}

#[test]
fn without_stitches_the_pocket_is_named_as_loose() {
    let built = build_shape(&pocket(), &options(1000, Stitching::None)).unwrap();
    assert!(built.bundle.stitches().is_empty() && found(&built, "stitched").is_none());
    let finding = found(&built, "loose-piece").unwrap();
    assert_eq!(finding.count, 1);
    assert!(finding.examples[0].contains("1 mm from the nearest piece"), "{finding:?}");
    // A pocket 5 cm away is not sewn by itself, but on request.
    let mut far = pocket();
    far.positions[169..].iter_mut().for_each(|p| p[2] += 0.05);
    let auto = build_shape(&far, &options(1000, Stitching::Auto)).unwrap();
    assert!(auto.bundle.stitches().is_empty() && found(&auto, "loose-piece").is_some());
    let asked = build_shape(&far, &options(1000, Stitching::Within(0.06))).unwrap();
    assert!(!asked.bundle.stitches().is_empty() && found(&asked, "loose-piece").is_none());
}

#[test]
fn two_borders_that_meet_are_sewn_once() {
    let mut shape = Shape::default();
    sheet(&mut shape, 10, [0.0; 3], [1.0, 0.5], 0.0);
    sheet(&mut shape, 13, [0.0, 0.5004, 0.0], [1.0, 0.52], 0.0);
    let built = build_shape(&shape, &options(2000, Stitching::Auto)).unwrap();
    let stitches = built.bundle.stitches();
    let width = built.bundle.manifest.pieces[0].width as usize;
    assert!((width * 3 / 4..width * 2).contains(&stitches.len()), "{} for {width}", stitches.len());
    let from: std::collections::BTreeSet<u32> = stitches.iter().map(|s| s.piece).collect();
    assert_eq!(from.len(), 1, "all from one side");
}

/// A pinned panel, and one below it without pins: the gap \[m\] between their borders, by the place along them.
fn bodice_and_skirt(gap: impl Fn(f64) -> f64) -> Shape {
    let mut shape = Shape::default();
    sheet(&mut shape, 25, [0.0; 3], [1.0, 0.5], 0.0);
    sheet(&mut shape, 23, [0.0, 0.5, 0.0], [1.0, 0.5], 0.0);
    shape.positions[..26 * 26].iter_mut().filter(|p| p[1] == 0.5).for_each(|p| p[1] -= gap(p[0]));
    shape
}

#[test]
fn a_skirt_that_would_fall_off_or_hang_from_its_side_is_sewn_along_its_waist() {
    let sewn = |gap: &dyn Fn(f64) -> f64| {
        let built = build_shape(&bodice_and_skirt(gap), &options(2000, Stitching::Auto)).unwrap();
        assert!(found(&built, "loose-piece").is_none());
        let width = f64::from(built.bundle.manifest.pieces[0].width);
        let kinds = ["hint-stitched", "hint-partly-sewn"].map(|kind| found(&built, kind).is_some());
        (built.bundle.stitches().len() as f64 / width, kinds)
    };
    // Farther away than an estimate reaches; a tenth of it close and the rest 5 mm away; and all of it close.
    for (gap, kinds) in [
        (&(|_| 9e-3) as &dyn Fn(f64) -> f64, [true, false]),
        (&|x| if x < 0.1 { 4e-4 } else { 5e-3 }, [true, false]),
        (&|_| 4e-4, [false, false]),
    ] {
        let (share, hints) = sewn(gap);
        assert!(share > 0.7 && hints == kinds, "{share} {hints:?}");
    }
    // Of two fifths that are close, one cannot tell whether the rest is sewn: a hint asks.
    let (share, hints) = sewn(&|x| if x < 0.4 { 4e-4 } else { 5e-3 });
    assert!(share < 0.6 && hints == [false, true], "{share} {hints:?}");
}

#[test]
fn the_belted_dress_hangs_together() {
    let Some(folder) = garments_or_skip("the_belted_dress_hangs_together") else { return };
    let built = build(&folder.join("dress_belted_202k.glb"), &pinned(4096, &["above:1.3"])).unwrap();
    assert!(found(&built, "loose-piece").is_none());
    let bundle = reread(&built.bundle);
    let mut cloth = Cloth::from_bundle("dress", &bundle).unwrap();
    // Pieces without pins hang on those of others.
    let tethers = cloth.stored_tethers().unwrap();
    let hang = |grid: &gimage_runtime::Grid| grid.range().filter(|k| tethers.of(*k)[0].exists()).count();
    let loose: Vec<_> = cloth.grids().iter().filter(|g| hang(g) == 0).map(|g| &g.name).collect();
    assert!(loose.is_empty(), "{loose:?}");
    cloth.damping = 1.0;
    let (start, stitches) = (cloth.positions().to_vec(), cloth.stitches().to_vec());
    let grids = cloth.grids().to_vec();
    let mut scene = Scene::new("dress");
    scene.cloths.push(cloth);
    let mut stepper = Stepper::on_cpu(scene, Options::default()).unwrap();
    (0..120).for_each(|_| _ = stepper.advance(1.0 / 60.0).unwrap());
    let now = stepper.positions(0).unwrap();
    let low = |list: &mut dyn Iterator<Item = f32>| list.fold(f32::INFINITY, f32::min);
    let (was, is) = (low(&mut start.iter().map(|p| p[1])), low(&mut now.iter().map(|p| p[1])));
    println!("{} stitches; the lowest point was at {was} m and is at {is} m", stitches.len());
    assert!(is > was - 0.15, "no piece falls out: {was} to {is}");
    for s in &stitches {
        let grid = &grids[s.piece as usize];
        let place = gimage_bundle::Place::of(grid.width, grid.height, s.at);
        let mut way = [0, 1, 2].map(|c: usize| -now[s.particle as usize][c]);
        for (k, share) in place.corners(grid.width).into_iter().zip(place.shares()) {
            (0..3).for_each(|c| way[c] += share * now[(grid.first + k) as usize][c]);
        }
        let far = way.iter().map(|x| x * x).sum::<f32>().sqrt();
        assert!(far < s.distance + 5e-3, "{far} m of {} m", s.distance);
    }
}

#[test]
fn the_border_of_a_pocket_rides_on_the_panel_that_it_is_sewn_to() {
    for n in [600, 3000] {
        let bundle = reread(&build_shape(&pocket(), &options(n, Stitching::Auto)).unwrap().bundle);
        let file = RenderFile::parse(bundle.render.as_ref().unwrap()).unwrap();
        let primitives = file.primitives().unwrap();
        let all = || primitives.iter().flat_map(|p| p.positions.iter().zip(&p.coords).zip(&p.offsets));
        let (mut border, mut inner) = (0, 0);
        for ((p, coord), offset) in all() {
            let [x, y] = [(p[0] - 0.31) / 0.36, (p[1] - 0.22) / 0.41].map(|t| (7.0 * t).round() as i32);
            // Vertices of the pocket stand 1 mm and more in front of the panel.
            if p[2] < 5e-4 {
                assert_eq!(coord[0], 0.0, "{n}: a vertex of the panel at {p:?}");
            } else if x == 0 || x == 7 || y == 0 || y == 7 {
                border += 1;
                let far = offset.iter().map(|x| x * x).sum::<f32>().sqrt();
                assert!(coord[0] == 0.0 && far < 2e-3, "{n}: {p:?} is bound to piece {}, {far} m away", coord[0]);
            } else {
                inner += 1;
                assert_eq!(coord[0], 1.0, "{n}: {p:?}");
            }
        }
        assert_eq!((border, inner), (28, 36));
        // At rest vertices are where the source has them all the same.
        let mesh = RenderMesh::from_bundle(&bundle).unwrap().unwrap();
        let mut scene = Scene::new("pocket");
        scene.cloths.push(Cloth::from_bundle("pocket", &bundle).unwrap());
        let stepper = Stepper::on_cpu(scene, Options::default()).unwrap();
        let mut vertices = Vec::new();
        stepper.wrap(0, &mesh, 1.0, &mut vertices).unwrap();
        let far = all()
            .zip(&vertices)
            .map(|((at, _), v)| (0..3).map(|c| (at.0[c] - v.position[c]).abs()).fold(0.0, f32::max));
        assert!(far.fold(0.0, f32::max) < 1e-6);
    }
}
