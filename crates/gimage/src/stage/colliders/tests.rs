use nalgebra::{Rotation3, Vector3};
use parry3d_f64::math::Vector;
use parry3d_f64::shape::{Ball, Capsule, Cuboid};

use super::*;
use crate::base::mesh::{Channel, Joint, Part, Semantic, Skeleton};
use crate::import::{FileCollider, FileShape};
use crate::stage::import::IDENTITY;

fn fit(mesh: &Mesh, cloth: &Mesh, options: &ColliderOptions) -> Option<(Vec<Collider>, Figures)> {
    fit_mesh(mesh, cloth, None, options).map(|(colliders, figures, _)| (colliders, figures))
}

/// A sphere of unit radius, `n` rings of `2 n` triangles, moved by `at`.
fn ball(n: u32, at: impl Fn([f64; 3]) -> [f64; 3]) -> Mesh {
    let mut mesh = Mesh { parts: vec![Part::default()], ..Mesh::default() };
    for i in 0..=n {
        for j in 0..2 * n {
            let (a, b) = (f64::from(i) / f64::from(n), f64::from(j) / f64::from(n));
            let ((s, c), (sin, cos)) = ((a * std::f64::consts::PI).sin_cos(), (b * std::f64::consts::PI).sin_cos());
            mesh.positions.push(at([s * cos, c, s * sin]));
        }
    }
    let at = |i: u32, j: u32| i * 2 * n + j % (2 * n);
    for (i, j) in (0..n).flat_map(|i| (0..2 * n).map(move |j| (i, j))) {
        mesh.triangles.push([at(i, j), at(i, j + 1), at(i + 1, j)]);
        mesh.triangles.push([at(i, j + 1), at(i + 1, j + 1), at(i + 1, j)]);
    }
    mesh.triangle_part = vec![0; mesh.triangles.len()];
    mesh
}

/// A capsule along x as a mesh: a ball whose halves are pulled apart.
fn limb(n: u32, half: f64, radius: f64) -> Mesh {
    ball(n, |p| [radius * p[1] + half * (8.0 * p[1]).clamp(-1.0, 1.0), radius * p[0], -radius * p[2]])
}

/// Gives each corner joint 0 for x < 0, else joint 1.
fn skinned(mut mesh: Mesh, parents: [Option<u32>; 2]) -> Mesh {
    let at = |v: u32| if mesh.positions[v as usize][0] < 0.0 { 0.0 } else { 1.0 };
    let corners: Vec<u32> = (0..3 * mesh.triangles.len() as u32).collect();
    let joints = mesh.triangles.iter().flatten().flat_map(|v| [at(*v), 0.0, 0.0, 0.0]).collect();
    let weights = corners.iter().flat_map(|_| [1.0, 0.0, 0.0, 0.0]).collect();
    let channel = |semantic, values| Channel { semantic, width: 4, values, corners: corners.clone() };
    mesh.channels = vec![channel(Semantic::Joints(0), joints), channel(Semantic::Weights(0), weights)];
    let joint = |(k, parent)| Joint {
        name: format!("bone {k}"),
        parent,
        inverse_bind: std::array::from_fn(|k| f64::from(k % 5 == 0)),
        world: std::array::from_fn(|k| f64::from(k % 5 == 0)),
    };
    mesh.skeleton = Skeleton { joints: parents.into_iter().enumerate().map(joint).collect() };
    mesh
}

#[test]
fn distances_are_those_of_parry() {
    let turn = Rotation3::new(Vector3::new(0.3, -0.7, 1.1));
    let center = Vector3::new(0.2, -0.1, 0.4);
    let vector = |p: Vector3<f64>| Vector::new(p.x, p.y, p.z);
    let cases: [(Form, Box<dyn parry3d_f64::shape::Shape>); 3] = [
        (Form::Sphere { radius: 0.3 }, Box::new(Ball::new(0.3))),
        (Form::Capsule { half_height: 0.4, radius: 0.2 }, Box::new(Capsule::new_y(0.4, 0.2))),
        (Form::Box { half: [0.1, 0.3, 0.2] }, Box::new(Cuboid::new(Vector::new(0.1, 0.3, 0.2)))),
    ];
    for (form, shape) in cases {
        let solid = Solid::new(form, center, &turn);
        for k in 0..400u32 {
            let at = |n: f64| ((f64::from(k) + 1.0) * n).fract() * 1.6 - 0.8;
            let local = Vector3::new(at(0.618_034), at(0.754_878), at(0.569_84));
            let truth = shape.as_ref().distance_to_local_point(vector(local), false);
            let found = solid.distance((turn * local + center).into());
            assert!((truth - found).abs() < 1e-9, "{form:?} {local:?}: {truth} {found}");
        }
        assert!((form.volume() / shape.mass_properties(1.0).mass() - 1.0).abs() < 1e-9, "{form:?}");
    }
}

/// The distance of a point from the surface of the hull of two balls: the least over all balls between them, which is a convex function.
fn to_hull(p: Vector3<f64>, half: f64, [low, high]: [f64; 2]) -> f64 {
    let at = |t: f64| (p - Vector3::new(0.0, (2.0 * t - 1.0) * half, 0.0)).norm() - (low + t * (high - low));
    let (mut a, mut b) = (0.0, 1.0);
    for _ in 0..200 {
        let (c, d) = (a + (b - a) / 3.0, b - (b - a) / 3.0);
        if at(c) < at(d) { b = d } else { a = c }
    }
    at(0.5 * (a + b)).min(at(0.0)).min(at(1.0))
}

#[test]
fn tapered_capsules_are_the_hull_of_two_balls() {
    for (half_height, radii) in [(0.4, [0.1, 0.3]), (0.3, [0.25, 0.05]), (0.11, [0.3, 0.1]), (0.5, [0.2, 0.2])] {
        let form = Form::TaperedCapsule { half_height, radii };
        let turn = Rotation3::new(Vector3::new(0.3, -0.7, 1.1));
        let center = Vector3::new(0.2, -0.1, 0.4);
        let solid = Solid::new(form, center, &turn);
        let (mut inside, count) = (0u32, 100_000u32);
        let half = form.half_extents();
        for k in 0..count {
            let at = |n: f64, by: f64| (((f64::from(k) + 1.0) * n).fract() * 2.0 - 1.0) * by;
            let local = Vector3::new(at(0.819_172_5, half[0]), at(0.671_043_6, half[1]), at(0.549_700_5, half[2]));
            let truth = to_hull(local, half_height, radii);
            inside += u32::from(truth < 0.0);
            if k % 50 == 0 {
                let found = solid.distance((turn * local + center).into());
                assert!((truth - found).abs() < 1e-9, "{form:?} {local:?}: {truth} {found}");
            }
        }
        let volume = 8.0 * half.iter().product::<f64>() * f64::from(inside) / f64::from(count);
        assert!((form.volume() / volume - 1.0).abs() < 0.01, "{form:?}: {} {volume}", form.volume());
    }
}

#[test]
fn a_mirrored_joint_mirrors_a_tapered_capsule() {
    let form = Form::TaperedCapsule { half_height: 0.4, radii: [0.1, 0.3] };
    let solid = Solid::new(form, Vector3::new(0.1, 0.5, 0.0), &Rotation3::new(Vector3::new(0.2, 0.4, -0.3)));
    let unit = |k: usize| f64::from(k.is_multiple_of(5));
    for mirror in 0..3 {
        let world = std::array::from_fn(|k| if k == 5 * mirror { -1.0 } else { unit(k) });
        let moved =
            solid.posed(&Joint { name: String::new(), parent: None, inverse_bind: std::array::from_fn(unit), world });
        for p in [[0.1, 0.9, 0.0], [0.3, 0.1, 0.2], [-0.4, 0.5, 0.7]] {
            let mut there = p;
            there[mirror] = -there[mirror];
            assert!((solid.distance(p) - moved.distance(there)).abs() < 1e-9, "{mirror}: {p:?}");
        }
    }
}

#[test]
fn a_cone_of_flesh_is_fitted_by_one_tapered_capsule() {
    // The hull of two balls as a mesh: thick at x = -0.3.
    let (half, [low, high]) = (0.3, [0.15, 0.06]);
    let along = (low - high) / (2.0 * half);
    let mesh = ball(40, |[x, y, z]| {
        let (at, radius) = if y > along { (half, high) } else { (-half, low) };
        [radius * y + at, radius * x, -radius * z]
    });
    let of = |kinds: &[Kind]| {
        let options = ColliderOptions { kinds: kinds.to_vec(), count: 1, ..ColliderOptions::default() };
        fit(&mesh, &Mesh::default(), &options).unwrap()
    };
    let (round, tapered) =
        (of(&[Kind::Sphere, Kind::Capsule]), of(&[Kind::Sphere, Kind::Capsule, Kind::TaperedCapsule]));
    let Form::TaperedCapsule { half_height, radii } = tapered.0[0].solid.form else { panic!("{tapered:?}") };
    let sorted = [radii[0].max(radii[1]), radii[0].min(radii[1])];
    assert!(
        (half_height - half).abs() < 0.01 && (sorted[0] - low).abs() < 0.005 && (sorted[1] - high).abs() < 0.005,
        "{tapered:?}"
    );
    assert!(tapered.1.body.p95 < 0.004 && tapered.1.body.p95 < 0.2 * round.1.body.p95, "{:?} {:?}", tapered.1, round.1);
}

#[test]
fn the_distance_to_an_ellipsoid_is_that_to_its_nearest_point() {
    let radii = [0.1, 0.5, 0.25];
    let form = Form::Ellipsoid { radii };
    let mesh = ball(160, |p| [0, 1, 2].map(|k| p[k] * radii[k]));
    let closest = crate::closest::Closest::new(&mesh.positions, &mesh.triangles);
    for k in 0..300u32 {
        let at = |n: f64| (f64::from(k) * n).fract() * 1.2 - 0.6;
        let p = [at(0.618_034), at(0.754_878), at(0.569_84)];
        let inside = (0..3).map(|k| (p[k] / radii[k]).powi(2)).sum::<f64>() < 1.0;
        let truth = closest.project(p).unwrap().distance * if inside { -1.0 } else { 1.0 };
        let found = form.distance(p.into());
        assert!((truth - found).abs() < 2e-4, "{p:?}: {truth} {found}");
    }
    // The centre, the axes and the plane across the shortest axis.
    assert!((form.distance(Vector3::zeros()) + 0.1).abs() < 1e-6);
    assert!((form.distance(Vector3::new(0.0, 0.9, 0.0)) - 0.4).abs() < 1e-9);
    assert!((form.distance(Vector3::new(0.0, 0.1, 0.0)) + 0.097_98).abs() < 1e-3);
}

#[test]
fn a_capsule_is_found_again_wherever_it_lies() {
    let turn = Rotation3::new(Vector3::new(0.5, 1.2, -0.4));
    let mut mesh = limb(24, 0.3, 0.07);
    mesh.positions.iter_mut().for_each(|p| *p = (turn * Vector3::from(*p) + Vector3::new(3.0, 1.0, -2.0)).into());
    let (colliders, figures) = fit(&mesh, &Mesh::default(), &ColliderOptions::default()).unwrap();
    assert_eq!((colliders.len(), &colliders[0].joint), (1, &None));
    let Form::Capsule { half_height, radius } = colliders[0].solid.form else { panic!("{colliders:?}") };
    // The mesh is a polyhedron inside the capsule.
    assert!((half_height - 0.3).abs() < 2e-3 && (radius - 0.07).abs() < 1e-3, "{half_height} {radius}");
    let center = Vector3::from(colliders[0].solid.center);
    assert!((center - Vector3::new(3.0, 1.0, -2.0)).norm() < 1e-3, "{center}");
    assert!(figures.body.max < 2e-3 && figures.outside < 2e-2 * colliders[0].solid.form.volume(), "{figures:?}");
}

#[test]
fn each_joint_has_its_own_solids_and_a_small_one_goes_to_its_parent() {
    let options = ColliderOptions::default();
    let (colliders, _) = fit(&skinned(limb(24, 0.3, 0.07), [None, Some(0)]), &Mesh::default(), &options).unwrap();
    let names: Vec<_> = colliders.iter().filter_map(|c| c.joint.clone()).collect();
    assert_eq!(names, ["bone 0", "bone 1"]);
    assert!(colliders[0].solid.center[0] < -0.05 && colliders[1].solid.center[0] > 0.05, "{colliders:?}");
    // A file whose pose is another than the one of the binding: the second bone is turned about y and lifted.
    let mut posed = skinned(limb(24, 0.3, 0.07), [None, Some(0)]);
    posed.skeleton.joints[1].world = [0.0, 0.0, -1.0, 0.0, 0.0, 1.0, 0.0, 0.0, 1.0, 0.0, 0.0, 0.0, 0.0, 0.5, 0.0, 1.0];
    let (moved, _) = fit(&posed, &Mesh::default(), &options).unwrap();
    let [x, y, z] = colliders[1].solid.center;
    let found = moved[1].solid.center;
    assert!((found[0] - z).abs() + (found[1] - y - 0.5).abs() + (found[2] + x).abs() < 1e-9, "{found:?}");
    assert!(moved[1].solid.distance([0.0, 0.5, -0.37]).abs() < 5e-3 && moved[0] == colliders[0]);
    // Mirrored, much larger, flat: the search for the rotation ends.
    for (linear, size) in [([-1.0, 1.0, 1.0], 1.0), ([100.0; 3], 100.0), ([1.0, 1.0, 0.0], 1.0), ([f64::NAN; 3], 1.0)] {
        let mut joint = posed.skeleton.joints[0].clone();
        (0..3).for_each(|k| joint.world[5 * k] = linear[k]);
        let solid = colliders[1].solid.posed(&joint);
        let scale = solid.form.thickness() / colliders[1].solid.form.thickness();
        assert!((scale - size).abs() < 1e-9 * size, "{linear:?}: {scale}");
        assert!(solid.center.iter().chain(&solid.rotation).all(|x| x.is_finite()), "{solid:?}");
    }
    // A joint that moves a tip of some triangles.
    let mut tip = limb(24, 0.3, 0.07);
    tip.positions.iter_mut().for_each(|p| p[0] -= 0.369);
    let (colliders, _) = fit(&skinned(tip, [None, Some(0)]), &Mesh::default(), &options).unwrap();
    assert_eq!(colliders.iter().filter_map(|c| c.joint.as_deref()).collect::<Vec<_>>(), ["bone 0"]);
}

#[test]
fn more_solids_come_nearer_and_the_number_is_a_limit() {
    // A bent tube that no single solid fits.
    let bent = ball(32, |p| {
        let angle = 1.5 * p[1];
        let across = 1.0 + 0.15 * p[0];
        [across * angle.sin(), across * angle.cos(), -0.15 * p[2]]
    });
    let fit =
        |count| fit(&bent, &Mesh::default(), &ColliderOptions { count, error: 0.004, ..Default::default() }).unwrap();
    let (one, few, many) = (fit(1), fit(3), fit(12));
    assert_eq!((one.0.len(), few.0.len()), (1, 3));
    assert!(many.0.len() > 3 && many.0.len() <= 12, "{}", many.0.len());
    let p95 = [one.1.body.p95, few.1.body.p95, many.1.body.p95];
    assert!(p95[0] > 1.5 * p95[1] && p95[1] > 1.5 * p95[2], "{p95:?}");
    assert!(missed(&one.1, one.0.len(), &ColliderOptions::default()).is_some());
    // The same on any number of threads.
    let pool = rayon::ThreadPoolBuilder::new().num_threads(1).build().unwrap();
    assert_eq!(pool.install(|| fit(3)), few);
}

#[test]
fn surfaces_inside_the_body_are_left_out() {
    let mut mesh = limb(24, 0.3, 0.1);
    let inner = ball(12, |p| [0.02 * p[0], 0.02 * p[1], 0.02 * p[2]]);
    let base = mesh.positions.len() as u32;
    mesh.positions.extend(&inner.positions);
    mesh.triangles.extend(inner.triangles.iter().map(|t| t.map(|v| v + base)));
    mesh.triangle_part.resize(mesh.triangles.len(), 0);
    let winding = winding(&mesh);
    assert!(samples(&mesh, &winding, 2000, 1).iter().all(|s| s.point.iter().any(|x| x.abs() > 0.05)));
    let (colliders, figures) = fit(&mesh, &Mesh::default(), &ColliderOptions::default()).unwrap();
    assert!(colliders.len() == 1 && figures.body.max < 3e-3, "{figures:?}");
    // Nothing can be touched of a body that is inside out.
    mesh.triangles.iter_mut().for_each(|t| t.swap(1, 2));
    let wrong = fit(&Mesh::default(), &Mesh::default(), &ColliderOptions::default());
    assert!(wrong.is_none());
}

#[test]
fn options_out_of_range_are_refused() {
    for (options, name) in [
        (ColliderOptions { error: 0.0, ..Default::default() }, "collider-error"),
        (ColliderOptions { error: f64::NAN, ..Default::default() }, "collider-error"),
        (ColliderOptions { count: 0, ..Default::default() }, "max-colliders"),
        (ColliderOptions { kinds: Vec::new(), ..Default::default() }, "collider-shapes"),
    ] {
        let found = options.check().unwrap_err().to_string();
        assert!(found.contains(name), "{found}");
    }
}

/// A collider of a file that follows a joint, in a node at `world`.
fn file_collider(shape: FileShape, joint: Option<u32>, world: [f64; 16]) -> FileCollider {
    FileCollider { source: "VRM", node: "hand".into(), joint, shape, world }
}

#[test]
fn colliders_of_a_file_are_used_where_they_fit() {
    let mut mesh = skinned(limb(24, 0.3, 0.07), [None, Some(0)]);
    // The file's pose is elsewhere than the mesh is bound: a quarter turn about z, and twice as large.
    let world = [0.0, 2.0, 0.0, 0.0, -2.0, 0.0, 0.0, 0.0, 0.0, 0.0, 2.0, 0.0, 0.5, 0.0, 0.0, 1.0];
    mesh.skeleton.joints.iter_mut().for_each(|j| j.world = world);
    let along = |half: f64| FileShape::Capsule { ends: [[half, 0.0, 0.0], [-half, 0.0, 0.0]], radii: [0.07; 2] };
    let of = |shape, source| {
        let options = ColliderOptions { source, ..Default::default() };
        let given = given::given(&[file_collider(shape, Some(0), world)], &mesh, &options).unwrap();
        fit_mesh(&mesh, &Mesh::default(), given, &options).unwrap()
    };
    let (colliders, figures, findings) = of(along(0.3), ColliderSource::Auto);
    assert_eq!(colliders.len(), 1);
    assert!(figures.body.p95 < 0.001, "{figures:?}");
    assert_eq!((findings[0].severity, findings[0].kind), (Severity::Note, "file-colliders"));
    let close = |a: [f64; 3], b: [f64; 3]| (0..3).all(|k| (a[k] - b[k]).abs() < 1e-9);
    assert!(close(colliders[0].bound.center, [0.0; 3]) && close(colliders[0].solid.center, [0.5, 0.0, 0.0]));
    let Form::Capsule { half_height, radius } = colliders[0].solid.form else { panic!("{colliders:?}") };
    assert!((half_height - 0.6).abs() < 1e-9 && (radius - 0.14).abs() < 1e-9, "it is as large as its node");
    // It reaches along y of the world.
    assert!(colliders[0].solid.distance([0.5, 0.74, 0.0]).abs() < 1e-9);
    // Half as long, it does not fit: others are fitted, unless it is asked for.
    let (fitted, _, findings) = of(along(0.1), ColliderSource::Auto);
    assert!(fitted.len() > 1 && findings[0].message.contains("were fitted instead"), "{findings:?}");
    let (kept, _, findings) = of(along(0.1), ColliderSource::File);
    assert!(kept.len() == 1 && findings[0].severity == Severity::Warning, "{findings:?}");
    let (others, _, findings) = of(along(0.3), ColliderSource::Fit);
    assert!(others.len() > 1 && findings.is_empty(), "{findings:?}");
    let none = given::given(&[], &mesh, &ColliderOptions { source: ColliderSource::File, ..Default::default() });
    assert!(none.is_err());
}

#[test]
fn shapes_of_files_become_solids() {
    let options = ColliderOptions { source: ColliderSource::File, ..Default::default() };
    let unit = std::array::from_fn(|k| f64::from(k % 5 == 0));
    let turned = FileShape::Capsule { ends: [[0.0, -1.0, 0.0], [0.0, 1.0, 0.0]], radii: [0.1, 0.3] };
    let shapes = [
        FileShape::Sphere { center: [0.0, 1.0, 0.0], radius: 0.5 },
        turned,
        FileShape::Capsule { ends: [[1.0; 3]; 2], radii: [0.1; 2] },
        FileShape::Cylinder { half_height: 1.0, radii: [0.2; 2] },
        FileShape::Box { half: [0.1, 0.2, 0.3] },
        FileShape::Capsule { ends: [[0.0, 1.0, 0.0], [0.0; 3]], radii: [0.5, 2.0] },
    ];
    let all: Vec<_> = shapes.into_iter().map(|s| file_collider(s, None, unit)).collect();
    let given = given::given(&all, &Mesh::default(), &options).unwrap().unwrap();
    let forms: Vec<_> = given.placed.iter().map(|p| p.solid.form).collect();
    assert_eq!(forms[0], Form::Sphere { radius: 0.5 });
    assert_eq!(forms[1], Form::TaperedCapsule { half_height: 1.0, radii: [0.3, 0.1] });
    // The larger ball is at the upper end of the file.
    assert!((given.placed[1].solid.distance([0.0, 1.5, 0.0]) - 0.2).abs() < 1e-12);
    assert!((given.placed[1].solid.distance([0.0, -1.5, 0.0]) - 0.4).abs() < 1e-12);
    assert_eq!(forms[2], Form::Sphere { radius: 0.1 });
    assert_eq!(forms[3], Form::Capsule { half_height: 0.8, radius: 0.2 });
    assert_eq!(forms[4], Form::Box { half: [0.1, 0.2, 0.3] });
    // One ball of this capsule holds the other.
    assert_eq!((forms[5], given.placed[5].solid.center), (Form::Sphere { radius: 2.0 }, [0.0; 3]));
    assert_eq!((given.findings[0].kind, given.findings[0].count), ("rounded-collider", 1));
}

/// A body that is a forearm (x from 0.3 to 0.6 m) of two joints along x, and a sleeve of some radius \[m\] around the upper arm,
/// which the body lacks, from x = -0.2 to 0.2 m.
fn bare_arm(radius: f64) -> (Mesh, Mesh) {
    let joint = |name: &str, parent, x: f64| {
        let mut inverse_bind = crate::import::IDENTITY;
        inverse_bind[12] = -x;
        let mut world = crate::import::IDENTITY;
        world[12] = x;
        Joint { name: name.into(), parent, inverse_bind, world }
    };
    let skeleton = Skeleton {
        joints: vec![joint("shoulder", None, -0.35), joint("elbow", Some(0), 0.3), joint("hand", Some(1), 0.6)],
    };
    let follow = |mut mesh: Mesh, joint: f32| {
        let corners = vec![0; 3 * mesh.triangles.len()];
        let channel = |semantic, values: Vec<f32>| Channel { semantic, width: 4, values, corners: corners.clone() };
        mesh.channels = vec![
            channel(Semantic::Joints(0), vec![joint, 0.0, 0.0, 0.0]),
            channel(Semantic::Weights(0), vec![1.0, 0.0, 0.0, 0.0]),
        ];
        mesh.skeleton = skeleton.clone();
        mesh
    };
    let mut forearm = limb(16, 0.12, 0.04);
    forearm.positions.iter_mut().for_each(|p| p[0] += 0.45);
    // So that the figure is of the height of a person.
    let mut head = limb(8, 0.05, 0.05);
    head.positions.iter_mut().for_each(|p| *p = [p[0] - 1.0, p[1] + 1.5, p[2]]);
    let first = forearm.positions.len() as u32;
    forearm.positions.extend(head.positions);
    forearm.triangles.extend(head.triangles.iter().map(|t| t.map(|v| v + first)));
    forearm.triangle_part = vec![0; forearm.triangles.len()];
    let mut sleeve = limb(16, 0.2, radius);
    // Without its rounded ends.
    sleeve.triangles.retain(|t| t.iter().all(|v| sleeve.positions[*v as usize][0].abs() < 0.2 + 0.3 * radius));
    assert!(!sleeve.triangles.is_empty());
    sleeve.triangle_part = vec![0; sleeve.triangles.len()];
    (follow(forearm, 1.0), follow(sleeve, 0.0))
}

#[test]
fn a_part_that_the_body_lacks_is_guessed_beneath_the_sleeve_around_it() {
    let (body, cloth) = bare_arm(0.07);
    let options = ColliderOptions::default();
    let (colliders, figures, findings) = fit_mesh(&body, &cloth, None, &options).unwrap();
    let (guessed, others): (Vec<_>, Vec<_>) = colliders.iter().partition(|c| c.guessed);
    assert!(!guessed.is_empty() && !others.is_empty() && figures.of_each.len() == colliders.len(), "{colliders:?}");
    assert!(guessed.iter().all(|c| c.joint.as_deref() == Some("shoulder")), "{guessed:?}");
    assert!(figures.of_each[others.len()..].iter().all(|e| e.p95 < 0.012), "{figures:?}");
    let inside = |p: [f64; 3]| guessed.iter().any(|c| c.bound.distance(p) < 0.0);
    for x in [-0.15, 0.0, 0.15] {
        assert!(inside([x, 0.0, 0.0]) && inside([x, 0.04, 0.0]) && inside([x, 0.0, -0.04]), "{x}: {guessed:?}");
        assert!(!inside([x, 0.0701, 0.0]) && !inside([x, 0.0, -0.0701]), "{x}: {guessed:?}");
        // The sleeve has room for folds.
        assert!(!inside([x, 0.055, 0.0]) && !inside([x, 0.0, -0.055]), "{x}: {guessed:?}");
    }
    assert!(findings.iter().any(|f| f.kind == "hint-guessed" && f.message.contains("shoulder")), "{findings:?}");

    let off = ColliderOptions { guess: Guess::Off, ..options.clone() };
    let (colliders, ..) = fit_mesh(&body, &cloth, None, &off).unwrap();
    assert_eq!(colliders, others.into_iter().cloned().collect::<Vec<_>>());
}

#[test]
fn narrowed_solids_are_as_long_as_before() {
    // A point of the surface on the longest axis, which stays, and one across it.
    for (form, [end, side]) in [
        (Form::Capsule { half_height: 0.3, radius: 0.1 }, [[0.0, 0.4, 0.0], [0.1, 0.0, 0.0]]),
        (Form::Box { half: [0.1, 0.2, 0.5] }, [[0.0, 0.0, 0.5], [0.0, 0.2, 0.0]]),
        (Form::Ellipsoid { radii: [0.5, 0.2, 0.1] }, [[0.5, 0.0, 0.0], [0.0, 0.2, 0.0]]),
        (Form::TaperedCapsule { half_height: 0.3, radii: [0.1, 0.1] }, [[0.0, -0.4, 0.0], [0.0, 0.0, 0.1]]),
    ] {
        let narrow = form.narrowed(0.7);
        for (form, share) in [(form, 1.0), (narrow, 0.7)] {
            let at = |p: [f64; 3], by: f64| form.distance(Vector3::from(p.map(|x| by * x))).abs();
            assert!(at(end, 1.0) < 1e-6 && at(side, share) < 1e-6, "{form:?}");
        }
    }
    let narrow = Form::TaperedCapsule { half_height: 0.3, radii: [0.2, 0.1] }.narrowed(0.7);
    let Form::TaperedCapsule { half_height, radii } = narrow else { panic!("{narrow:?}") };
    assert!((2.0 * half_height + radii[0] + radii[1] - 0.9).abs() < 1e-12, "{narrow:?}");
    assert_eq!(Form::Sphere { radius: 0.2 }.narrowed(0.5), Form::Sphere { radius: 0.1 });
}

#[test]
fn nothing_is_guessed_where_there_is_a_body_or_cloth_hangs_free() {
    let guessed = |body: &Mesh, cloth: &Mesh| {
        let (colliders, ..) = fit_mesh(body, cloth, None, &ColliderOptions::default()).unwrap();
        colliders.iter().filter(|c| c.guessed).count()
    };
    // Of 1.6 m, 12 % are 0.19 m.
    let (body, wide) = bare_arm(0.3);
    assert_eq!(guessed(&body, &wide), 0);
    let (_, sleeve) = bare_arm(0.07);
    let mut arm = limb(16, 0.2, 0.03);
    arm.channels = Vec::new();
    let mut whole = body.clone();
    let first = whole.positions.len() as u32;
    whole.positions.extend(arm.positions);
    whole.triangles.extend(arm.triangles.iter().map(|t| t.map(|v| v + first)));
    whole.triangle_part = vec![0; whole.triangles.len()];
    whole.channels.iter_mut().for_each(|c| c.corners = vec![0; 3 * whole.triangles.len()]);
    assert_eq!(guessed(&whole, &sleeve), 0);
    // A sleeve that lies on its body needs no other.
    assert_eq!(guessed(&body, &Mesh::default()), 0);
}

/// Frames of [`bare_arm`], in some of which a joint takes the forearm into the upper side of the sleeve, 5 cm deep.
fn lowered(joint: usize, some: usize, of: usize) -> Motion {
    let rest = vec![IDENTITY; 3];
    let mut pose = rest.clone();
    (pose[joint][12], pose[joint][13]) = (-0.45, 0.06);
    Motion { frames: (0..of).map(|k| if k < some { pose.clone() } else { rest.clone() }).collect() }
}

#[test]
fn bare_limbs_that_animations_take_through_clothes_are_no_part_of_the_surface() {
    let (mut body, cloth) = bare_arm(0.07);
    let passing = |body: &Mesh, guessed: &[u32], motion: &Motion| bare::passing([body, &cloth], guessed, motion, 0.012);
    // The clothes of a joint and of its neighbour touch where a limb bends.
    assert!(passing(&body, &[0], &lowered(1, 20, 20)).is_empty());
    body.channels[0].values[0] = 2.0;
    assert_eq!(passing(&body, &[0], &lowered(2, 1, 20)), [2]);
    // One frame of two hundred does not count, nor do clothes with a body.
    assert!(passing(&body, &[0], &lowered(2, 1, 200)).is_empty());
    assert!(passing(&body, &[1], &lowered(2, 20, 20)).is_empty());
    assert!(passing(&body, &[0], &Motion { frames: Vec::new() }).is_empty());
    let left_out = bare::bare([&body, &cloth], &[2]);
    let share = left_out.iter().filter(|out| **out).count() as f64 / left_out.len() as f64;
    assert!(share > 0.9 && !bare::bare([&body, &cloth], &[1]).contains(&true), "{share}");
    // The same limb within the sleeve stays.
    let mut inner = body.clone();
    inner.positions.iter_mut().for_each(|p| p[0] -= 0.45);
    let left_out = bare::bare([&inner, &cloth], &[2]);
    // Triangles from one end of it to the other.
    let xs = |t: usize| inner.corners(t).map(|p| p[0]);
    let sides: Vec<usize> = (0..left_out.len())
        .filter(|t| xs(*t).iter().any(|x| *x < 0.0) && xs(*t).iter().any(|x| (0.0..0.3).contains(x)))
        .collect();
    assert!(!sides.is_empty() && !sides.iter().any(|t| left_out[*t]), "{sides:?}");
}

#[test]
fn a_surface_is_closed_where_triangles_are_left_out() {
    let body = bare_arm(0.07).0;
    let half: Vec<bool> = (0..body.triangles.len()).map(|t| body.corners(t).iter().any(|p| p[0] > 0.45)).collect();
    let (whole, part) = (surface::surface(&body, &[]).unwrap(), surface::surface(&body, &half).unwrap());
    assert!(part.body.triangles.len() < whole.body.triangles.len() && part.closed == 1, "{part:?}");
    assert!(part.body.positions.iter().all(|p| p[0] < 0.5));
    assert!(surface::surface(&body, &vec![true; body.triangles.len()]).is_err());
}
