//! Maps of hard disks, by every way and by the best.

use super::*;
use crate::base::shapes;
use crate::base::surface::Surface;
use distortion::flips;
use proptest::prelude::*;

/// The records and maps of a surface laid on `side` x `side` cells, by the best way and embedded.
fn mapped(s: &Surface, side: u32, enough: usize) -> [(ParameterizeRecord, Vec<[f64; 2]>); 2] {
    let (disk, uv) = shapes::laid(s, side, side);
    let fixed = disk.boundary_mask();
    let shape = disk.shape(&fixed);
    let options = NewtonOptions::default();
    let (mut best, mut embedded) = (uv.clone(), uv.clone());
    let first = parameterize(shape, &mut best, 8, &options, enough).expect("a map");
    let second = parameterize_by(Way::Embedded, shape, &mut embedded, 8, &options, enough).expect("a map");
    for map in [&best, &embedded] {
        assert_eq!(flips(&disk.triangles, map), 0);
        assert!(fixed.iter().zip(uv.iter().zip(map)).all(|(f, (a, b))| !f || a == b), "the boundary moved");
    }
    [(first, best), (second, embedded)]
}

#[test]
fn every_hard_shape_has_a_map_of_bounded_energy() {
    for (name, s) in shapes::all().into_iter().chain(shapes::hard()) {
        let [(best, _), (embedded, _)] = mapped(&s, 60, 8192);
        // The energy of a disk squeezed onto a square of a thousandth or more of its shape's aspect.
        let bound = if ["ribbon", "star"].contains(&name) { 1e7 } else { 500.0 };
        assert!(best.newton.end < bound && embedded.newton.end < bound, "{name}: {best:?} {embedded:?}");
        assert!(embedded.newton.end < 1.2 * best.newton.end, "{name}: {best:?} {embedded:?}");
    }
}

#[test]
fn a_disk_whose_convex_map_is_crushed_is_embedded() {
    // Mean-value and uniform weights both flip triangles of these, or start at energies above 1e9.
    for s in [shapes::comb(12, 40), shapes::sock(12, 200, 30.0)] {
        let [(best, _), _] = mapped(&s, 60, 8192);
        assert!(best.way == Way::Embedded && best.newton.end < 500.0, "{best:?}");
    }
}

#[test]
fn a_crushed_start_is_spread_and_newton_goes_on_until_it_converges() {
    let s = shapes::holed(6);
    let (disk, mut uv) = shapes::laid(&s, 60, 60);
    let fixed = disk.boundary_mask();
    let options = NewtonOptions::default();
    let record = parameterize_by(Way::Whole, disk.shape(&fixed), &mut uv, 8, &options, 8192).expect("a map");
    assert!(record.newton.start > 1e9, "no crushed start: {record:?}");
    assert!(record.newton.converged && record.newton.end < 100.0, "{record:?}");
}

#[test]
fn a_large_disk_of_arms_is_embedded_with_newton_steps_on_its_coarse_levels() {
    let s = shapes::comb(12, 120);
    let [(best, _), (all, _)] = mapped(&s, 60, 800);
    assert!(best.way == Way::Embedded, "{best:?}");
    let [(whole, _), _] = mapped(&s, 60, 8192);
    assert!(best.newton.end < 1.2 * whole.newton.end && all.newton.end < 1.2 * whole.newton.end);
}

#[test]
fn maps_have_the_same_bits_on_one_thread_and_on_four() {
    let threads = |n: usize| {
        let pool = rayon::ThreadPoolBuilder::new().num_threads(n).build().expect("a pool");
        pool.install(|| mapped(&shapes::slivers(60, 60, 1e-3), 60, 1000).map(|m| m.1))
    };
    assert_eq!(threads(1), threads(4));
}

#[test]
fn the_better_start_is_kept_where_the_first_is_crushed() {
    for (name, s) in shapes::hard() {
        let (disk, uv) = shapes::laid(&s, 60, 60);
        let fixed = disk.boundary_mask();
        let shape = disk.shape(&fixed);
        let starts = [false, true].map(|uniform| {
            let (mut system, mut map) = (System::new(shape.triangles, &fixed), uv.clone());
            start::weighted(&mut system, shape, &mut map, Start::Convex { passes: 8 }, uniform)?;
            let mut rest = RestShapes::new(shape.positions, shape.triangles, shape.wanted);
            scale_to(&mut rest, shape.triangles, &map);
            Some(distortion::energy(&rest.shapes, shape.triangles, &map))
        });
        let mut map = uv.clone();
        let made =
            parameterize_by(Way::Whole, disk.shape(&fixed), &mut map, 8, &NewtonOptions::default(), usize::MAX / 2);
        let Some(record) = made else {
            assert!(starts.iter().flatten().all(|e| !e.is_finite()), "{name}: {starts:?}");
            continue;
        };
        let expected = match starts {
            [Some(a), Some(b)] if a > 1e4 => a.min(b),
            [Some(a), _] | [None, Some(a)] => a,
            _ => f64::NAN,
        };
        assert!((record.newton.start / expected - 1.0).abs() < 1e-9, "{name}: {starts:?} {record:?}");
    }
}

#[test]
fn a_poor_map_of_the_simpler_disk_is_not_refined() {
    for (name, s) in shapes::hard() {
        let (disk, mut uv) = shapes::laid(&s, 60, 60);
        let fixed = disk.boundary_mask();
        let options = NewtonOptions::default();
        let made = parameterize_by(Way::CoarseToFine, disk.shape(&fixed), &mut uv, 8, &options, 300);
        assert!(made.is_none_or(|r| r.newton.end < 106.0), "{name}: {made:?}");
    }
}

/// Thirty holes in a cube of twelve triangles: every triangle is drawn for one, and a surface must be left.
#[test]
fn a_blob_of_holes_alone_is_a_surface() {
    let s = shapes::blob(7331261079989045743, 1, 30);
    assert_eq!(s.triangles.len(), 1);
    mapped(&s, 8, 8192);
}

proptest! {
    #![proptest_config(ProptestConfig::with_cases(24))]
    #[test]
    fn random_blobs_have_maps(seed in any::<u64>(), cells in 1usize..200, holes in 0usize..40, side in 8u32..40) {
        mapped(&shapes::blob(seed, cells, holes), side, if seed % 2 == 0 { 200 } else { 8192 });
    }
}
