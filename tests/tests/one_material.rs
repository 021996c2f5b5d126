//! One T-shirt of one material as three bundles, of 64 x 64, 128 x 128 and 256 x 256 texels and two cuts, comes to rest in
//! one shape.

use gimage::closest::Closest;
use gimage::options::Seams;
use gimage_runtime::*;
use gimage_tests::{asset, build, texels};

type V = [f64; 3];

/// A fabric that yields enough to show a wrong stiffness, and bends stiffly enough that there is one shape only.
const FABRIC: Material = Material {
    warp: 60.0,
    weft: 60.0,
    shear: 6.0,
    bend: 2e-4,
    density: 0.15,
    damping: 6.0,
    thickness: None,
    friction: 1.0,
};

/// The shirt before and after, by texels, and its triangles.
struct Settled {
    rest: Vec<V>,
    end: Vec<V>,
    triangles: Vec<[u32; 3]>,
}

/// The shirt held by all that is above 1.4 m, drawn down and forward for two and a half seconds.
fn settled(count: u32, seams: Seams, substeps: u32) -> Settled {
    let mut options = texels(count);
    (options.image.seams, options.gate.metrics) = (seams, false);
    let built = build(&asset("tshirt.glb"), &options).unwrap();
    let mut cloth = Cloth::from_bundle("tshirt", &built.bundle).unwrap();
    cloth.set_material(&FABRIC).unwrap();
    let held = |k: &usize| cloth.particles()[*k].exists() && cloth.positions()[*k][1] > 1.4;
    let pins: Vec<usize> = (0..cloth.len()).filter(held).collect();
    pins.into_iter().for_each(|k| cloth.set_pinned(k, true).unwrap());
    // Its middle is the origin, near which numbers are finest.
    cloth.place(cloth.positions().iter().map(|p| [p[0], p[1] - 1.1, p[2]]).collect()).unwrap();
    let mut triangles = Vec::new();
    for (g, (j, i)) in cloth.grids().iter().flat_map(|g| {
        let cells = (0..g.height - 1).flat_map(|j| (0..g.width - 1).map(move |i| (j, i)));
        cells.map(move |cell| (g, cell))
    }) {
        let k = g.first + j * g.width + i;
        let corners = [k, k + g.width, k + g.width + 1, k + 1];
        if corners.iter().all(|k| cloth.particles()[*k as usize].exists()) {
            let [a, b, c, d] = corners;
            triangles.extend([[a, b, c], [a, c, d]]);
        }
    }
    let rest: Vec<V> = cloth.positions().iter().map(|p| p.map(f64::from)).collect();
    let mut scene = Scene::new("tshirt");
    scene.cloths.push(cloth);
    scene.gravity = [0.0, -9.81, 1.5];
    let (backend, solver) = (Backend::Cpu, Solver::Xpbd);
    let options =
        Options { backend, solver, substeps: Some(substeps), tethers: 0, normals: false, ..Options::default() };
    // One thread walks over the rows once a step, in half the work of two.
    let options = Options { threads: 1, ..options };
    let mut stepper = Stepper::new(scene, options, None).unwrap();
    (0..150).for_each(|_| assert!(stepper.advance(1.0 / 60.0).is_ok()));
    assert!(stepper.take_faults().is_empty());
    let end = stepper.positions(0).unwrap().iter().map(|p| [0, 1, 2].map(|c| f64::from(p[c]))).collect();
    Settled { rest, end, triangles }
}

impl Settled {
    /// Where points of the shirt at rest have gone.
    fn follow(&self, points: &[V]) -> Vec<V> {
        let found = Closest::new(&self.rest, &self.triangles).project_all(points);
        let to = |n: gimage::closest::Nearest| {
            let corners = self.triangles[n.triangle as usize].map(|k| self.end[k as usize]);
            [0, 1, 2].map(|c| (0..3).map(|k| n.barycentric[k] * corners[k][c]).sum())
        };
        found.into_iter().map(|n| to(n.unwrap())).collect()
    }
}

fn rms(a: &[V], b: &[V]) -> f64 {
    let square = |(p, q): (&V, &V)| (0..3).map(|c| (p[c] - q[c]).powi(2)).sum::<f64>();
    (a.iter().zip(b).map(square).sum::<f64>() / a.len() as f64).sqrt()
}

#[test]
fn one_shirt_from_three_bundles_and_two_cuts_settles_alike() {
    // The finer the grid, the shorter the step that its particles can follow.
    let coarse = settled(4096, Seams::Short, 48);
    let points: Vec<V> = coarse.rest.clone();
    let ends = [&coarse, &settled(16384, Seams::Uv, 96), &settled(65536, Seams::Short, 192)].map(|s| s.follow(&points));
    let side = |c: usize| {
        let of = |start: f64, pick: fn(f64, f64) -> f64| ends[0].iter().map(|p| p[c]).fold(start, pick);
        of(f64::MIN, f64::max) - of(f64::MAX, f64::min)
    };
    let diagonal = (0..3).map(|c| side(c).powi(2)).sum::<f64>().sqrt();
    // It has gone several times as far as the shapes may differ.
    let gone = rms(&ends[0], &points) / diagonal;
    assert!(gone > 0.025, "{gone}");
    for (a, b) in [(0, 1), (1, 2), (0, 2)] {
        let error = rms(&ends[a], &ends[b]) / diagonal;
        assert!(error < 0.01, "{a} {b}: {error}");
    }
}
