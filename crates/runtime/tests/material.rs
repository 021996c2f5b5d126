//! One material is the same cloth whatever its grid, its steps and its backend.

use crate::support::{self, FRAME, run, scene};
use gimage_runtime::*;

type V = [f64; 3];

fn options(substeps: u32) -> Options {
    let backend = Backend::Cpu;
    Options {
        backend,
        solver: Solver::Xpbd,
        substeps: Some(substeps),
        tethers: 0,
        normals: false,
        ..Options::default()
    }
}

/// Where texel (u, v) of a grid lies in the square of 1 m; edges lie on edges.
fn place(u: f64, v: f64, skew: f64) -> [f64; 2] {
    let pi = std::f64::consts::PI;
    [u + 0.5 * skew * (pi * u).sin() * (pi * v).cos(), v + skew * (pi * u).sin() * (pi * v).sin()]
}

/// The point at arc length `s` of the rail that the flag hangs from: folds of half a metre.
fn rail(s: f64) -> [f64; 2] {
    let mut at = [0.0; 2];
    for n in 0..400 {
        let t = (f64::from(n) + 0.5) / 400.0 * s;
        let heading = 1.2 * (2.0 * std::f64::consts::TAU * t).sin();
        at[0] += heading.cos() * s / 400.0;
        at[1] += heading.sin() * s / 400.0;
    }
    at
}

/// A flag of 1 m x 1 m, of `n` x `n` particles, sewn to a bent rail by its upper edge; texture coordinates are those of
/// the fabric.
fn flag(n: u32, skew: f64, material: &Material) -> Cloth {
    let part = |k: u32| f64::from(k) / f64::from(n - 1);
    let plane: Vec<[f64; 2]> = (0..n * n).map(|k| place(part(k % n), part(k / n), skew)).collect();
    let far = |a: u32, b: u32| {
        let (a, b) = (plane[a as usize], plane[b as usize]);
        (a[0] - b[0]).hypot(a[1] - b[1]) as f32
    };
    let rest = (0..n * n).map(|k| {
        let (right, down, up) = (k % n + 1 < n, k / n + 1 < n, k >= n);
        let to = |there: bool, other: u32| if there { far(k, other) } else { 0.0 };
        [to(right, k + 1), to(down, k + n), to(right && down, k + n + 1), to(right && up, (k + 1).wrapping_sub(n))]
    });
    let on_rail = |p: &[f64; 2]| {
        let [x, z] = rail(p[0]);
        [x as f32, -p[1] as f32, z as f32]
    };
    let mut cloth = Cloth::new(Parts {
        name: "flag".into(),
        grids: vec![Grid { name: "flag".into(), first: 0, width: n, height: n }],
        positions: plane.iter().map(on_rail).collect(),
        particles: vec![Particle::Free { next: None }; (n * n) as usize],
        rest: Rest::Image(rest.collect()),
        mass: Mass::Constant(1.0),
    })
    .unwrap();
    cloth.set_grain(Some(plane.iter().map(|p| p.map(|x| x as f32)).collect())).unwrap();
    cloth.set_material(material).unwrap();
    (0..n as usize).for_each(|k| cloth.set_pinned(k, true).unwrap());
    cloth
}

/// Where 33 x 33 points of the fabric have come to rest.
fn settled(n: u32, skew: f64, substeps: u32, material: &Material) -> Vec<V> {
    let stepper = run(scene(flag(n, skew, material)), options(substeps), 240);
    let p = stepper.positions(0).unwrap();
    let side = (n - 1) as usize;
    let point = |k: usize| {
        let (x, y) = ((k % 33) as f64 / 32.0, (k / 33) as f64 / 32.0);
        let (mut u, mut v) = (x, y);
        for _ in 0..100 {
            let at = place(u, v, skew);
            (u, v) = ((u + x - at[0]).clamp(0.0, 1.0), (v + y - at[1]).clamp(0.0, 1.0));
        }
        let (fu, fv) = (u * side as f64, v * side as f64);
        let (i, j) = ((fu as usize).min(side - 1), (fv as usize).min(side - 1));
        let (a, b) = (fu - i as f64, fv - j as f64);
        [0, 1, 2].map(|c| {
            let at = |i: usize, j: usize| f64::from(p[j * n as usize + i][c]);
            (1.0 - b) * ((1.0 - a) * at(i, j) + a * at(i + 1, j))
                + b * ((1.0 - a) * at(i, j + 1) + a * at(i + 1, j + 1))
        })
    };
    (0..33 * 33).map(point).collect()
}

/// RMS distance over the diagonal.
fn apart(a: &[V], b: &[V]) -> f64 {
    let side = |c: usize| {
        let of = |start: f64, pick: fn(f64, f64) -> f64| b.iter().map(|p| p[c]).fold(start, pick);
        of(f64::MIN, f64::max) - of(f64::MAX, f64::min)
    };
    let diagonal = (0..3).map(|c| side(c).powi(2)).sum::<f64>().sqrt();
    let square = |(p, q): (&V, &V)| (0..3).map(|c| (p[c] - q[c]).powi(2)).sum::<f64>();
    (a.iter().zip(b).map(square).sum::<f64>() / a.len() as f64).sqrt() / diagonal
}

/// Soft enough that all of it shows in the shape.
const FABRIC: Material = Material {
    warp: 30.0,
    weft: 25.0,
    shear: 8.0,
    bend: 1e-4,
    density: 0.15,
    damping: 4.0,
    thickness: None,
    friction: 1.0,
};

#[test]
fn one_flag_on_three_grids_and_a_distorted_one_hangs_alike() {
    let fine = settled(129, 0.0, 96, &FABRIC);
    for (n, skew, substeps) in [(33, 0.0, 32), (65, 0.0, 48), (65, 0.1, 48), (33, 0.0, 64)] {
        let error = apart(&settled(n, skew, substeps, &FABRIC), &fine);
        assert!(error < 3e-3, "{n} x {n}, {skew}, {substeps} substeps: {error}");
    }
    // Each number of the material shows: halved, it is another flag.
    let base = settled(33, 0.0, 32, &FABRIC);
    type Change = fn(&mut Material);
    let changes: [(&str, Change); 4] = [
        ("warp", |m| m.warp *= 0.5),
        ("bend", |m| m.bend *= 0.25),
        ("density", |m| m.density *= 2.0),
        ("no bending", |m| m.bend = 0.0),
    ];
    for (name, change) in changes {
        let mut other = FABRIC;
        change(&mut other);
        let difference = apart(&settled(33, 0.0, 32, &other), &base);
        assert!(difference > 6e-3, "{name}: {difference}");
    }
}

#[test]
fn the_step_does_not_matter() {
    let end = |step: f64, substeps: u32| {
        let mut stepper =
            Stepper::on_cpu(scene(flag(33, 0.0, &FABRIC)), Options { step, ..options(substeps) }).unwrap();
        (0..240).for_each(|_| assert!(stepper.advance(FRAME).is_ok()));
        let p = stepper.positions(0).unwrap();
        p.iter().map(|p| [0, 1, 2].map(|c| f64::from(p[c]))).collect::<Vec<V>>()
    };
    let base = end(1.0 / 60.0, 64);
    for (step, substeps) in [(1.0 / 30.0, 128), (1.0 / 120.0, 48), (1.0 / 50.0, 64)] {
        let error = apart(&end(step, substeps), &base);
        assert!(error < 2e-3, "{step} {substeps}: {error}");
    }
}

/// A strip that sticks out 100 mm from a rail 400 mm wide, `n` particles long: the slope from the rail to its end.
/// Along its free sides a plate of which only the mean curvature counts gives way; so it is wide.
fn droop(n: u32, bend: f64, turned: bool) -> f64 {
    // Two columns hold the slope; what is free begins half-way between them.
    let h = 0.1 / (f64::from(n) - 0.5);
    let (right, down) = ([(0.1 + 0.5 * h) as f32, 0.0, 0.0], [0.0, 0.0, 0.4]);
    let flat = Flat { width: n + 1, height: 4 * n - 3, right, down, ..Flat::square("strip", n) };
    let flat = if turned { Flat { width: 4 * n - 3, height: n + 1, right: down, down: right, ..flat } } else { flat };
    let mut cloth = flat.cloth().unwrap();
    let strip = Material { bend, warp: 1000.0, weft: 1000.0, shear: 300.0, damping: 15.0, ..Material::default() };
    cloth.set_material(&strip).unwrap();
    for k in 0..cloth.len() {
        if f64::from(cloth.positions()[k][0]) < 1.5 * h {
            cloth.set_pinned(k, true).unwrap();
        }
    }
    let stepper = run(scene(cloth), Options { threads: 1, ..options(500) }, 60);
    let along = |p: &&[f32; 4]| p[3] > 0.0 && (p[2] - 0.2).abs() < 1e-3;
    let end = stepper.positions(0).unwrap().iter().filter(along).max_by(|a, b| a[0].total_cmp(&b[0])).unwrap();
    f64::from(-end[1]) / (f64::from(end[0]) - 0.5 * h)
}

#[test]
fn a_cantilever_droops_as_in_the_standard_test() {
    // F. T. Peirce's cantilever (ASTM D1388): where density g (length / 2)^3 is the stiffness in bending, the line from
    // the edge to the end of the strip is 41.5 degrees steep.
    let bend = 0.15 * 9.81 * 0.05f64.powi(3);
    let expected = 41.5f64.to_radians().tan();
    for (n, turned) in [(17, false), (17, true), (25, false)] {
        let found = droop(n, bend, turned);
        assert!((found / expected - 1.0).abs() < 0.06, "{n}, {turned}: {found} for {expected}");
    }
}

#[test]
fn free_cloth_keeps_its_momentum_and_comes_to_rest() {
    // Crumpled, with a seam, no damping but that of the solver.
    let mut cloth = support::two_charts(13);
    (0..cloth.len()).for_each(|k| cloth.set_pinned(k, false).unwrap());
    cloth.set_material(&Material { damping: 0.0, bend: 1e-3, ..FABRIC }).unwrap();
    let mut positions = cloth.positions().to_vec();
    for (k, p) in positions.iter_mut().enumerate() {
        // Duplicates lie at one place.
        p[2] +=
            0.04 * (7.0 * p[0]).sin() * (9.0 * p[1]).cos() + if k % 13 % 12 > 0 { 0.002 * (k % 3) as f32 } else { 0.0 };
    }
    cloth.place(positions).unwrap();
    cloth.velocity = [0.5, -0.2, 0.1];
    let still = Scene { gravity: [0.0; 3], ..scene(cloth) };
    let mut stepper = Stepper::on_cpu(still, options(16)).unwrap();
    let mut last = f64::INFINITY;
    for frame in 0..240 {
        stepper.advance(FRAME).unwrap();
        let (now, before) = (stepper.positions(0).unwrap(), stepper.previous(0).unwrap());
        let (mut momentum, mut mass, mut kinetic) = ([0.0; 3], 0.0, 0.0);
        for (a, b) in now.iter().zip(before) {
            let m = 1.0 / f64::from(a[3]);
            mass += m;
            for c in 0..3 {
                let v = f64::from(a[c] - b[c]) / (FRAME / 16.0);
                momentum[c] += m * v;
                kinetic += 0.5 * m * v * v;
            }
        }
        let drift = (0..3).map(|c| (momentum[c] / mass - [0.5, -0.2, 0.1][c]).abs()).fold(0.0, f64::max);
        assert!(drift < 1e-3, "frame {frame}: {drift} m/s");
        if frame % 60 == 59 {
            assert!(kinetic < last * 1.01, "frame {frame}: {kinetic} after {last}");
            last = kinetic;
        }
    }
}

#[test]
fn any_number_of_threads_gives_the_same_bits() {
    let mut large = support::on_colliders(290);
    large.cloths[0] = support::made_of(large.cloths[0].clone());
    let bits = |threads| {
        let stepper = run(large.clone(), Options { threads, ..options(4) }, 5);
        stepper.positions(0).unwrap().iter().map(|v| v.map(f32::to_bits)).collect::<Vec<_>>()
    };
    let one = bits(1);
    assert!(one == bits(2) && one == bits(5));
}

#[test]
fn a_cut_ends_membrane_and_bending() {
    // Cut right across below its middle: the lower part falls, the upper one stays.
    let mut cloth = support::curtain(33);
    cloth.set_material(&FABRIC).unwrap();
    let mut stepper = run(scene(cloth), options(16), 30);
    stepper.cut([0.5, -0.52, 5.0], [-1.0, -0.52, -5.0], [2.0, -0.52, -5.0]).unwrap();
    (0..60).for_each(|_| assert!(stepper.advance(FRAME).is_ok()));
    let p = stepper.positions(0).unwrap();
    assert!(p[32 * 33 + 16][1] < -1.8 && p[20 * 33 + 5][1] < -1.2, "{:?}", p[32 * 33 + 16]);
    assert!(p[10 * 33 + 16][1] > -0.6, "{:?}", p[10 * 33 + 16]);
    assert!(stepper.take_faults().is_empty());
}

#[test]
fn only_cloth_of_a_material_pays_for_it() {
    let shaders = |cloth: Cloth, solver| {
        let plan = Stepper::on_cpu(scene(cloth), Options { solver, ..options(1) }).unwrap().plan();
        // The exact step has the shader of the plain one, with another rule.
        let name = |p: &PlannedPass| {
            if matches!(p.form.pass(), Some(Pass::IntegrateExact(_))) { "integrate_exact" } else { p.shader }
        };
        plan.passes.iter().map(name).collect::<Vec<_>>()
    };
    let flat = || Flat::square("flat", 8).cloth().unwrap();
    let of = |bend| {
        let mut cloth = flat();
        cloth.set_material(&Material { bend, ..FABRIC }).unwrap();
        cloth
    };
    let is_new = |s: &&str| ["integrate_exact", "moments", "seam_moments", "bend", "membrane"].contains(s);
    assert_eq!(shaders(flat(), Solver::Xpbd).iter().filter(|s| is_new(s)).count(), 0);
    assert_eq!(shaders(of(1e-4), Solver::Classic), shaders(flat(), Solver::Classic));
    let four = ["membrane"; 4];
    let end = ["guard", "restore"];
    assert_eq!(shaders(of(0.0), Solver::Xpbd), [&["integrate_exact"][..], &four, &end].concat());
    assert_eq!(shaders(of(1e-4), Solver::Xpbd), [&["integrate_exact", "moments", "bend"][..], &four, &end].concat());
    let sewn = support::made_of(support::two_charts(5));
    let begin = ["integrate_exact", "moments", "seam_moments", "bend", "seams"];
    assert_eq!(shaders(sewn, Solver::Xpbd), [&begin[..], &four, &["seams"], &end].concat());
}
