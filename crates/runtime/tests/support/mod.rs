//! Cloths, scenes and adapters for the tests.
// Tests on the CPU use a part of it.
#![cfg_attr(not(feature = "gpu"), allow(dead_code))]

#[cfg(feature = "gpu")]
pub mod adapter;
#[cfg(feature = "gpu")]
pub mod alike;
pub mod bound_mesh;
pub mod limb;
#[cfg(feature = "gpu")]
pub mod rig;
#[cfg(feature = "gpu")]
pub mod run;
pub mod source_mesh;

#[cfg(feature = "gpu")]
pub use adapter::*;
use gimage_runtime::*;

/// A tube around y, `n` columns (the last the duplicate of the first) of `rows` rows; row 0 closes to one point of
/// `fold` duplicates if that is above 1.
pub fn tube(n: u32, rows: u32, fold: u32) -> Cloth {
    let index = |i: u32, j: u32| j * n + i;
    let (mut positions, mut particles) = (Vec::new(), Vec::new());
    for j in 0..rows {
        for i in 0..n {
            let angle = std::f32::consts::TAU * (i % (n - 1)) as f32 / (n - 1) as f32;
            let tip = j == 0 && fold > 1 && i < fold;
            let (s, c) = angle.sin_cos();
            let y = -0.05 * j as f32;
            positions.push(if tip { [0.02, 0.1, 0.01] } else { [0.2 * c, y, 0.2 * s] });
            let next = if tip {
                Some(index((i + 1) % fold, 0))
            } else if i == 0 && (j > 0 || fold < 2) {
                Some(index(n - 1, j))
            } else if i == n - 1 && (j > 0 || fold < 2) {
                Some(index(0, j))
            } else {
                None
            };
            particles.push(Particle::Free { next });
        }
    }
    let far = |a: [f32; 3], b: [f32; 3]| {
        let d: f32 = (0..3).map(|c| (a[c] - b[c]).powi(2)).sum();
        // A spring between duplicates would have no length; it is none.
        d.sqrt()
    };
    let at = |i: u32, j: u32| positions[index(i, j) as usize];
    let rest = (0..n * rows).map(|k| {
        let (i, j) = (k % n, k / n);
        let to = |ok: bool, di: u32, j: u32| if ok { 0.9 * far(at(i, k / n), at(i + di, j)) } else { 0.0 };
        [
            to(i + 1 < n, 1, j),
            to(j + 1 < rows, 0, j + 1),
            to(i + 1 < n && j + 1 < rows, 1, j + 1),
            to(i + 1 < n && j > 0, 1, j.wrapping_sub(1)),
        ]
    });
    let rest = Rest::Image(rest.collect());
    let grids = vec![Grid { name: "tube".into(), first: 0, width: n, height: rows }];
    Cloth::new(Parts { name: "tube".into(), grids, positions, particles, rest, mass: Mass::Constant(1e-3) }).unwrap()
}

/// The tube hung by its tip or, without one, by the seam's first point.
pub fn hung_tube(fold: u32) -> Cloth {
    let mut cloth = tube(17, 12, fold);
    cloth.set_pinned(0, true).unwrap();
    cloth.damping = 1.0;
    cloth
}

/// One collider of each kind under a flat cloth, with friction and motion.
pub fn all_colliders() -> Vec<Collider> {
    let q = [0.2f32, -0.5, 0.3, 0.7];
    let norm = q.iter().map(|x| x * x).sum::<f32>().sqrt();
    let rotation = q.map(|x| x / norm);
    let radii = [0.15, 0.1, 0.2];
    let shapes = [
        (Shape::HalfSpace, [0.0, -0.25, 0.0], [0.0, 0.0, 0.0, 1.0]),
        (Shape::Sphere { radius: 0.2 }, [0.25, -0.15, 0.25], rotation),
        (Shape::Capsule { half_height: 0.2, radius: 0.08 }, [0.7, -0.05, 0.3], rotation),
        (Shape::Box { half: [0.1, 0.05, 0.2] }, [0.3, -0.05, 0.75], rotation),
        (Shape::Ellipsoid { radii, closest: false }, [0.75, -0.08, 0.75], rotation),
        (Shape::Ellipsoid { radii, closest: true }, [0.5, -0.09, 0.5], rotation),
        (Shape::TaperedCapsule { half_height: 0.15, radii: [0.1, 0.05] }, [0.15, -0.06, 0.55], rotation),
    ];
    let moving = |(shape, center, rotation)| {
        let (velocity, spin) = ([0.1, 0.0, 0.05], [0.0, 0.5, 0.1]);
        Collider { rotation, friction: 0.3, velocity, spin, ..Collider::new(shape, center) }
    };
    shapes.into_iter().map(moving).collect()
}

/// The same where the tube ends: a start deep inside flattens springs to no length, which have no direction.
pub fn below() -> Vec<Collider> {
    let lower = |mut c: Collider| {
        c.center = [c.center[0] - 0.1, c.center[1] - 0.4, c.center[2] - 0.1];
        c
    };
    all_colliders().into_iter().map(lower).collect()
}

/// A scene with one cloth.
pub fn scene(cloth: Cloth) -> Scene {
    let mut scene = Scene::new("test");
    scene.cloths.push(cloth);
    scene
}

/// A horizontal square of `n` x `n` particles that has just met the colliders.
pub fn on_colliders(n: u32) -> Scene {
    let mut cloth = Flat { origin: [0.0, 0.03, 0.0], ..Flat::square("flat", n) }.cloth().unwrap();
    cloth.velocity = [0.0, -1.0, 0.0];
    cloth.damping = 0.5;
    Scene { colliders: all_colliders(), ..scene(cloth) }
}

/// Gusts on every particle, or on triangles.
pub fn wind(triangles: bool) -> Wind {
    let force = if triangles {
        WindForce::Triangles { density: 1.2, drag: 1.0, lift: 0.5 }
    } else {
        WindForce::Push { response: 0.8 }
    };
    Wind { velocity: [2.0, 0.3, 1.0], gust: 1.0, gust_size: 0.3, force }
}

/// The scenes that the backends are compared on, by name.
pub fn compared() -> Vec<(&'static str, Scene)> {
    let windy = |triangles| {
        let scene = scene::builtin("s1", 33).unwrap();
        Scene { wind: Some(wind(triangles)), ..scene }
    };
    vec![
        ("flat", scene::builtin("s1", 32).unwrap()),
        ("seam", scene(hung_tube(2))),
        ("ring of 3", scene(hung_tube(3))),
        ("ring of 4", Scene { colliders: below(), ..scene(hung_tube(4)) }),
        ("all colliders", on_colliders(32)),
        ("wind", windy(false)),
        ("wind on triangles", windy(true)),
    ]
}

/// As [`compared`], with colliders that cloth falls on instead of starting deep inside them.
pub fn outside() -> Vec<(&'static str, Scene)> {
    let mut all = compared();
    let mut cloth = tube(17, 12, 4);
    cloth.velocity = [0.0, -1.5, 0.0];
    let lower = |mut c: Collider| {
        c.center[1] -= 0.5;
        c
    };
    let colliders = below().into_iter().map(lower).collect();
    all.retain(|(name, _)| !["ring of 4", "all colliders"].contains(name));
    all.push(("falls on all colliders", falling(32)));
    all.push(("ring of 4 that falls", Scene { colliders, ..scene(cloth) }));
    all
}

/// A scene whose colliders have no edges and no iterations, so that a hundred steps in contact do not make much of the
/// rounding of one.
pub fn smooth(mut scene: Scene) -> Scene {
    scene.colliders.retain(|c| matches!(c.shape, Shape::HalfSpace | Shape::Sphere { .. } | Shape::Capsule { .. }));
    scene
}

/// As [`on_colliders`], from above them.
fn falling(n: u32) -> Scene {
    let mut flat = on_colliders(n);
    let above: Vec<_> = flat.cloths[0].positions().iter().map(|p| [p[0], p[1] + 0.25, p[2]]).collect();
    flat.cloths[0].place(above).unwrap();
    flat.cloths[0].velocity = [0.0, -2.5, 0.0];
    flat
}

/// Cloth of a fabric that bends, heavy enough that particles differ in mass.
pub fn made_of(mut cloth: Cloth) -> Cloth {
    let material = Material { warp: 300.0, weft: 200.0, shear: 30.0, bend: 2e-4, ..Material::default() };
    cloth.set_material(&material).unwrap();
    cloth
}

/// Scenes with compliance and materials, for XPBD.
pub fn soft() -> Vec<(&'static str, Scene)> {
    let with = |mut scene: Scene, compliance| {
        scene.cloths[0].compliance = compliance;
        scene
    };
    // Every other spring is stiff, so that both rules are at work in one block.
    let image = |cloth: &Cloth| (0..cloth.len()).map(|k| [0, 1, 2, 3].map(|d| 1e-4 * ((k + d) % 3) as f32)).collect();
    let ring = hung_tube(3);
    let uneven = Compliance::Image(image(&ring));
    let hung = scene::builtin("s1", 34).unwrap().cloths.remove(0);
    // It lands late: where cloth crumples, many steps in contact make much of the rounding of one.
    let mut falls = falling(24);
    falls.cloths[0] = made_of(falls.cloths[0].clone());
    falls.cloths[0].velocity = [0.3, -1.0, 0.1];
    vec![
        ("a material", scene(made_of(hung))),
        ("a material, in wind", Scene { wind: Some(wind(true)), ..scene(made_of(tube(18, 11, 1))) }),
        ("a material, seams", scene(made_of(hung_tube(3)))),
        ("a material, sewn charts", scene(made_of(two_charts(17)))),
        ("a material, on colliders", falls),
        ("stitches across a seam", scene(patched_charts(17, true))),
        ("a material, stitches", scene(made_of(patched_charts(13, true)))),
        ("soft", scene::builtin("s1k", 33).unwrap()),
        ("soft by an image", with(scene(ring), uneven)),
        ("soft, on colliders", with(falling(24), Compliance::Constant(1e-4))),
    ]
}

/// A frame \[s\].
pub const FRAME: f64 = 1.0 / 60.0;

/// A stepper on the CPU after some frames.
pub fn run(scene: Scene, options: Options, frames: u32) -> Stepper {
    let mut stepper = Stepper::on_cpu(scene, options).unwrap();
    (0..frames).for_each(|_| assert!(stepper.advance(FRAME).is_ok()));
    assert!(stepper.take_faults().is_empty());
    stepper
}

/// The measures of the first cloth.
pub fn measured(stepper: &Stepper) -> Measures {
    let dt = stepper.options().step / f64::from(stepper.substeps());
    let (now, before) = (stepper.positions(0).unwrap(), stepper.previous(0).unwrap());
    measure(&stepper.scene().cloths[0], now, before, dt, stepper.scene().gravity)
}

/// One step leaves the first cloth within 3e-6 m of where it is in f64.
pub fn is_exact(name: &str, scene: Scene, options: Options) {
    let options = Options { substeps: Some(1), backend: Backend::Cpu, threads: 1, ..options };
    let mut stepper = Stepper::on_cpu(scene.clone(), options.clone()).unwrap();
    assert_eq!(stepper.advance(options.step).unwrap().steps, 1);
    let mut exact = Reference::new(scene, options).unwrap();
    exact.step(1);
    let (now, _) = exact.positions(0).unwrap();
    for (a, b) in stepper.positions(0).unwrap().iter().zip(now) {
        assert!((0..3).all(|c| (f64::from(a[c]) - b[c]).abs() < 3e-6), "{name}: {a:?} {b:?}");
    }
}

/// The period \[s\] in which the hem of a swinging sheet of 32 x 32 particles crosses the middle, over ten seconds.
pub fn swing_period(mut stepper: Stepper) -> f64 {
    let (mut last, mut crossings) = (0.05, Vec::new());
    for frame in 1..=600 {
        stepper.advance(FRAME).unwrap();
        let hem = &stepper.positions(0).unwrap()[32 * 31..];
        let z = hem.iter().map(|p| f64::from(p[2])).sum::<f64>() / 32.0;
        if last * z < 0.0 {
            crossings.push(f64::from(frame - 1) + last / (last - z));
        }
        last = z;
    }
    2.0 * (crossings[crossings.len() - 1] - crossings[0]) / (crossings.len() - 1) as f64 * FRAME
}

/// An upright square of `n` x `n` particles and 1 m, hung by its first row; x to the right, y down from 0.
pub fn curtain(n: u32) -> Cloth {
    let (right, down) = ([1.0, 0.0, 0.0], [0.0, -1.0, 0.0]);
    let mut cloth = Flat { right, down, ..Flat::square("curtain", n) }.cloth().unwrap();
    (0..n as usize).for_each(|k| cloth.set_pinned(k, true).unwrap());
    cloth
}

/// Two upright charts of `n` x `n` particles side by side, each 0.5 m wide and 1 m high, sewn along x = 0.5 and held at
/// x = 0.
pub fn two_charts(n: u32) -> Cloth {
    let (mut positions, mut particles) = (Vec::new(), Vec::new());
    let (dx, dy) = (0.5 / (n - 1) as f32, 1.0 / (n - 1) as f32);
    for chart in 0..2 {
        for (j, i) in (0..n).flat_map(|j| (0..n).map(move |i| (j, i))) {
            positions.push([(chart * (n - 1) + i) as f32 * dx, -(j as f32) * dy, 0.0]);
            let next = match (chart, i) {
                (0, i) if i == n - 1 => Some(n * n + j * n),
                (1, 0) => Some(j * n + n - 1),
                _ => None,
            };
            particles.push(if (chart, i) == (0, 0) { Particle::Pinned { next } } else { Particle::Free { next } });
        }
    }
    let grid = |g: u32| Grid { name: format!("chart {g}"), first: g * n * n, width: n, height: n };
    let diagonal = dx.hypot(dy);
    let rest = Rest::Constant(vec![[dx, dy, diagonal, diagonal]; 2]);
    let grids = vec![grid(0), grid(1)];
    Cloth::new(Parts { name: "charts".into(), grids, positions, particles, rest, mass: Mass::Constant(1e-3) }).unwrap()
}

/// The charts of [`two_charts`] with a patch of 9 x 7 particles, 0.3 m wide and 0.24 m high, 1 cm in front of their seam. Its border is
/// stitched to them if `tied`.
pub fn patched_charts(n: u32, tied: bool) -> Cloth {
    let charts = two_charts(n);
    let (mut positions, mut particles) = (charts.positions().to_vec(), charts.particles().to_vec());
    let (dx, dy, first) = (0.3 / 8.0, 0.04, 2 * n * n);
    let mut stitches = Vec::new();
    for (j, i) in (0..7).flat_map(|j| (0..9).map(move |i| (j, i))) {
        let [x, y] = [0.37 + dx * i as f32, 0.5 + dy * j as f32];
        positions.push([x, -y, 0.01]);
        particles.push(Particle::Free { next: None });
        if j % 6 == 0 || i % 8 == 0 {
            let piece = u32::from(x > 0.5);
            let at = [2.0 * (x - 0.5 * piece as f32), y];
            stitches.push(Stitch { particle: first + 9 * j + i, piece, at, distance: 0.01 });
        }
    }
    let mut grids = charts.grids().to_vec();
    grids.push(Grid { name: "patch".into(), first, width: 9, height: 7 });
    let Rest::Constant(mut lengths) = charts.rest().clone() else { panic!("charts have constant lengths") };
    lengths.push([dx, dy, dx.hypot(dy), dx.hypot(dy)]);
    let (rest, mass) = (Rest::Constant(lengths), Mass::Constant(1e-3));
    let mut cloth = Cloth::new(Parts { name: "patched".into(), grids, positions, particles, rest, mass }).unwrap();
    if tied {
        cloth.set_stitches(stitches).unwrap();
    }
    cloth
}

/// A square folded to three layers that are `gap` \[m\] apart, above a table.
pub fn folded(n: u32, gap: f32) -> Scene {
    let mut cloth = Flat::square("sheet", n).cloth().unwrap();
    cloth.damping = 0.5;
    let bend = std::f32::consts::PI * gap / 2.0;
    let straight = (1.0 - 2.0 * bend) / 3.0;
    let place = |p: &[f32; 3]| {
        let layer = (p[0] / (straight + bend)).floor().min(2.0);
        let along = p[0] - layer * (straight + bend);
        let angle = 2.0 * (along - straight).max(0.0) / gap;
        let far = along.min(straight) + gap / 2.0 * angle.sin();
        let x = if layer == 1.0 { straight - far } else { far };
        [x, gap * (layer + 1.0) + gap / 2.0 * (1.0 - angle.cos()), p[2]]
    };
    cloth.place(cloth.positions().iter().map(place).collect()).unwrap();
    let table = Collider { friction: 0.5, ..Collider::new(Shape::HalfSpace, [0.0; 3]) };
    Scene { colliders: vec![table], ..scene(cloth) }
}

/// A cloth whose motion dies away.
pub fn calm(flat: Flat) -> Cloth {
    let mut cloth = flat.cloth().unwrap();
    cloth.damping = 0.5;
    cloth
}

fn friction_table() -> Collider {
    Collider { friction: 0.5, ..Collider::new(Shape::HalfSpace, [0.0; 3]) }
}

/// A square that collapses on a table.
pub fn dropped(n: u32) -> Scene {
    let mut scene = Scene::new("drop");
    scene.cloths.push(calm(Flat { origin: [0.0, 1.05, 0.0], down: [0.1, -1.0, 0.05], ..Flat::square("sheet", n) }));
    scene.colliders.push(friction_table());
    scene
}

/// Three squares held by two corners each swing against a ball.
pub fn draped(n: u32) -> Scene {
    let mut scene = Scene::new("drape");
    for layer in 0..3 {
        let away = 0.05 * layer as f32;
        let flat = Flat { origin: [-0.5, 0.5 + away, 0.3 + away], down: [0.0, 0.0, 1.0], ..Flat::square("sheet", n) };
        let mut cloth = calm(flat);
        [0, n - 1].into_iter().for_each(|k| cloth.set_pinned(k as usize, true).unwrap());
        scene.cloths.push(cloth);
    }
    scene.colliders.push(Collider::new(Shape::Sphere { radius: 0.3 }, [0.0, -0.2, 0.0]));
    scene
}

/// The scene with contact of a tier, at a distance too small for particles to keep triangles apart.
pub fn with_tier(mut scene: Scene, tier: ContactTier, share: f32) -> Scene {
    for cloth in &mut scene.cloths {
        let spacing = 1.0 / (cloth.grids()[0].width - 1) as f32;
        cloth.contact = Some(ClothContact { tier, distance: Some(share * spacing), friction: 0.3, layer: 0 });
    }
    scene
}
