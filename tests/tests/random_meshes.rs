//! Random surfaces of any genus, with and without boundary, of one side and of two: each must come out whole.

use gimage::Error;
use gimage_tests::shapes::{Random, Shape, growth, sheet, twisted, voxels};
use gimage_tests::{build_shape, faults, point, texels};
use proptest::prelude::*;

/// `GIMAGE_CASES` asks for another number of cases, for a longer search.
fn config(cases: u32) -> ProptestConfig {
    let cases = std::env::var("GIMAGE_CASES").ok().and_then(|n| n.parse().ok()).unwrap_or(cases);
    // Seeds of failures are not kept: a failure names its case, which belongs into a test of its own.
    ProptestConfig { cases, failure_persistence: None, max_shrink_iters: 40, ..ProptestConfig::default() }
}

/// Builds every component as a piece and fails with everything that is wrong. Returns the number of pieces.
fn sound(shape: &Shape, budget: u32, fit: bool) -> Result<usize, TestCaseError> {
    let mut options = if fit { texels(budget) } else { point(budget) };
    options.component.accessory_area = 0.0;
    options.gate.metrics = false;
    match build_shape(shape, &options) {
        Ok(built) => {
            let wrong = faults(&built);
            prop_assert!(wrong.is_empty(), "{}", wrong.join("; "));
            Ok(built.bundle.manifest.pieces.len())
        }
        // With every triangle taken away there is nothing to build.
        Err(Error::Empty { .. }) if shape.triangles.is_empty() => Ok(0),
        Err(e) => Err(TestCaseError::fail(e.to_string())),
    }
}

fn blob(seed: u64, side: i32, cells: usize) -> (Shape, Random) {
    let mut random = Random(seed);
    let set = growth(side, cells, &mut random);
    let shape = voxels(&set, &mut random).jittered(0.12, &mut random);
    (shape, random)
}

proptest! {
    #![proptest_config(config(24))]

    #[test]
    fn closed_surfaces_of_any_genus(seed: u64, side in 3..6i32, cells in 1..60usize, budget in 600..2500u32, fit: bool) {
        let (shape, _) = blob(seed, side, cells);
        prop_assert!(sound(&shape, budget, fit)? > 0);
    }

    #[test]
    fn surfaces_with_holes(seed: u64, side in 3..6i32, cells in 1..40usize, share in 0.01..0.4, fit: bool) {
        let (shape, mut random) = blob(seed, side, cells);
        sound(&shape.holed(share, &mut random), 2000, fit)?;
    }

    #[test]
    fn sheets_and_tubes(
        seed: u64, nx in 1..14usize, ny in 1..14usize, rough in 0.0..0.5, share in 0.0..0.2, tube: bool, fit: bool,
    ) {
        let mut random = Random(seed);
        let bumps: [f64; 4] = std::array::from_fn(|_| 6.0 * random.signed());
        let high = |u: f64, v: f64| rough * ((bumps[0] * u + bumps[1] * v).sin() + (bumps[2] * u * v + bumps[3]).cos());
        let shape = if tube {
            let mut t = twisted(nx + 3, ny, 0, 1.0, &mut random);
            t.positions.iter_mut().for_each(|p| p[1] += high(p[0], p[2]));
            t
        } else {
            sheet(nx, ny, &mut random, |u, v| [2.0 * u, high(u, v), 3.0 * v])
        };
        let shape = shape.holed(share, &mut random).jittered(0.01, &mut random);
        sound(&shape, 1500, fit)?;
    }

    #[test]
    fn strips_of_one_side_or_two(
        seed: u64, n in 5..40usize, m in 1..6usize, half_twists in 0..6usize, width in 0.1..0.9, share in 0.0..0.1, fit: bool,
    ) {
        let mut random = Random(seed);
        let strip = twisted(n, m, half_twists, width, &mut random).holed(share, &mut random).jittered(0.01, &mut random);
        sound(&strip, 1200, fit)?;
    }
}

#[test]
fn generators_make_what_they_say() {
    use gimage::topology::Topology;
    let mut random = Random(7);
    let t = Topology::of(&twisted(12, 2, 1, 0.5, &mut random).triangles);
    assert_eq!((t.euler, t.boundary_loops, t.misoriented_edges > 0), (0, 1, true));
    let t = Topology::of(&twisted(12, 2, 2, 0.5, &mut random).triangles);
    assert_eq!((t.euler, t.boundary_loops, t.is_oriented_manifold()), (0, 2, true));
    let cube = voxels(&growth(3, 27, &mut random), &mut random);
    let t = Topology::of(&cube.triangles);
    assert_eq!((t.euler, t.boundary_loops, t.triangles, t.is_oriented_manifold()), (2, 0, 108, true));
    // A frame of eight voxels round a hole is a torus.
    let ring = (0..9).filter(|k| *k != 4).map(|k| [k / 3, k % 3, 0]).collect();
    let t = Topology::of(&voxels(&ring, &mut random).triangles);
    assert_eq!((t.euler, t.boundary_loops, t.is_oriented_manifold()), (0, 0, true));
}
