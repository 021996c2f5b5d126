//! The figure of assets/ from its file to a walk: dressed with the defaults, it wears its clothes on its body.

#[path = "../../crates/cli/examples/character/main.rs"]
mod character;
use std::sync::LazyLock;

use crate::adapter;
use crate::motion::{LEAD, Motion};
use gimage::closest::Closest;
use gimage::colliders::{ColliderOptions, Tier};
use gimage::import::{Character, ImportOptions, import};
use gimage::mesh::{Mesh, Semantic};
use gimage::pipeline::{Built, dress};
use gimage::progress::Quiet;
use gimage_bundle::dir::write_dir;
use gimage_runtime::draw::{Camera, Facet, Hidden, Paint, Software, View};
use gimage_runtime::{BodyCollider, Cloth, Collider, Flat, Options, Scene, Shape, Stepper, wgpu};
use gimage_tests::{asset, texels};

const FRAME: f64 = 1.0 / 60.0;
/// Seconds of the walk.
const WALK: f64 = 2.4;

static BUILT: LazyLock<Built> = LazyLock::new(|| {
    let options = ColliderOptions { tier: Tier::Capsules, ..ColliderOptions::default() };
    dress(&asset("figure.glb"), &texels(4096), &options, &Quiet).expect("the figure dresses")
});

/// The same with the surface of the body.
static ON_SURFACE: LazyLock<Built> = LazyLock::new(|| {
    let options = ColliderOptions { tier: Tier::Surface, ..ColliderOptions::default() };
    dress(&asset("figure.glb"), &texels(4096), &options, &Quiet).expect("the figure dresses")
});

/// The body mesh of the figure, skinned by its own file.
struct Skin {
    mesh: Mesh,
    follows: Vec<[(usize, f64); 4]>,
    nodes: Vec<usize>,
}

impl Skin {
    fn new(character: &Character) -> Self {
        let options = ImportOptions { pieces: vec!["Body".into()], ..ImportOptions::default() };
        let mesh = import(&asset("figure.glb"), &options).unwrap().mesh;
        let (joints, weights) =
            (mesh.channel(&Semantic::Joints(0)).unwrap(), mesh.channel(&Semantic::Weights(0)).unwrap());
        let mut follows = vec![[(0, 0.0); 4]; mesh.positions.len()];
        for (t, triangle) in mesh.triangles.iter().enumerate() {
            for (c, v) in triangle.iter().enumerate() {
                let (j, w) = (joints.at(t, c).unwrap(), weights.at(t, c).unwrap());
                follows[*v as usize] = [0, 1, 2, 3].map(|k| (j[k] as usize, f64::from(w[k])));
            }
        }
        let nodes = mesh.skeleton.joints.iter().map(|j| character.node(&j.name).unwrap()).collect();
        Skin { mesh, follows, nodes }
    }

    fn at(&self, worlds: &[[f64; 16]]) -> Vec<[f64; 3]> {
        let moved = |p: &[f64; 3], (joint, weight): (usize, f64)| {
            let bind = &self.mesh.skeleton.joints[joint].inverse_bind;
            let apply = |m: &[f64; 16], p: [f64; 3]| {
                [0, 1, 2].map(|r| m[r] * p[0] + m[4 + r] * p[1] + m[8 + r] * p[2] + m[12 + r])
            };
            apply(&worlds[self.nodes[joint]], apply(bind, *p)).map(|x| x * weight)
        };
        let all = self.mesh.positions.iter().zip(&self.follows);
        all.map(|(p, own)| own.iter().map(|pair| moved(p, *pair)).fold([0.0; 3], |s, q| [0, 1, 2].map(|c| s[c] + q[c])))
            .collect()
    }

    /// For each point how deep \[m\] it is inside the body; 0 outside.
    fn depths(&self, worlds: &[[f64; 16]], points: &[[f64; 3]]) -> Vec<f64> {
        let body = self.at(worlds);
        let near = Closest::new(&body, &self.mesh.triangles).project_all(points);
        let depth = |(p, near): (&[f64; 3], _)| {
            let near: gimage::closest::Nearest = Option::unwrap(near);
            let [a, b, c] = self.mesh.triangles[near.triangle as usize].map(|v| body[v as usize]);
            let (u, v) = ([0, 1, 2].map(|k| b[k] - a[k]), [0, 1, 2].map(|k| c[k] - a[k]));
            let n = [u[1] * v[2] - u[2] * v[1], u[2] * v[0] - u[0] * v[2], u[0] * v[1] - u[1] * v[0]];
            let side: f64 = (0..3).map(|k| n[k] * (p[k] - near.point[k])).sum();
            if side < 0.0 { near.distance } else { 0.0 }
        };
        points.iter().zip(near).map(depth).collect()
    }
}

/// The figures of a walk.
struct Walk {
    /// Depths \[m\] of all free particles in all frames, and the share of frames in which any is deeper than 1 mm.
    depths: Vec<f64>,
    deep_frames: f64,
    /// The farthest that a particle gets from the place that its joints give it \[m\], in each piece.
    astray: Vec<f64>,
    /// Stretch of 99 % of the springs, and of all, in the worst frame.
    stretch: [f64; 2],
    positions: Vec<[f32; 4]>,
}

impl Walk {
    fn depth(&self, share: f64) -> f64 {
        self.depths[((self.depths.len() - 1) as f64 * share) as usize]
    }
}

type Device = (wgpu::Device, wgpu::Queue);

/// Walks for some seconds of the animation; every `every`-th frame is judged.
fn walk(built: &Built, seconds: f64, every: usize, device: Option<&Device>) -> Walk {
    let bundle = &built.bundle;
    let mut cloth = Cloth::from_bundle("figure", bundle).unwrap();
    assert_eq!(cloth.thickness, Some(0.003), "half the distance that colliders are fitted to");
    let motion = Motion::new(&asset("figure.glb"), &cloth, "Walk");
    let skin = Skin::new(&motion.character);
    cloth.follow_joints(&motion.matrices(&cloth, -LEAD)).unwrap();
    let body = BodyCollider::of_bundle(bundle);
    let colliders = body.iter().map(|part| part.collider).collect();
    let scene = Scene { cloths: vec![cloth.clone()], colliders, ..Scene::new("figure") };
    let mut stepper = match device {
        Some((device, queue)) => Stepper::new(scene, Options::default(), Some((device, queue))).unwrap(),
        None => Stepper::on_cpu(scene, Options::default()).unwrap(),
    };
    let mut walk =
        Walk { depths: vec![], deep_frames: 0.0, astray: vec![0.0; 2], stretch: [0.0; 2], positions: vec![] };
    let (frames, lead) = ((seconds / FRAME).round() as usize, (LEAD / FRAME).round() as usize);
    let mut judged = 0.0;
    for frame in 1..=lead + frames {
        let time = (frame as f64 - lead as f64) * FRAME;
        let matrices = motion.matrices(&cloth, time);
        stepper.set_joints(0, &matrices).unwrap();
        stepper.move_body(0, 0, &body, &matrices).unwrap();
        let positions = step(&mut stepper, device, frame > lead && frame % every == 0);
        if positions.is_empty() {
            continue;
        }
        let health = stepper.examine(0, &positions, &positions).unwrap().stretch.unwrap();
        walk.stretch = [walk.stretch[0].max(health.p99), walk.stretch[1].max(health.max)];
        judge(&mut walk, &cloth, &skin, (&motion.worlds(time), &matrices), &positions);
        judged += 1.0;
        walk.positions = positions;
    }
    assert!(stepper.take_faults().is_empty());
    walk.deep_frames /= judged;
    walk.depths.sort_by(f64::total_cmp);
    walk
}

/// Makes a step, and returns the positions if they are asked for.
fn step(stepper: &mut Stepper, device: Option<&Device>, judged: bool) -> Vec<[f32; 4]> {
    let Some((device, queue)) = device else {
        stepper.advance(FRAME).unwrap();
        return if judged { stepper.positions(0).unwrap().to_vec() } else { Vec::new() };
    };
    let mut encoder = device.create_command_encoder(&Default::default());
    stepper.record(&mut encoder, FRAME).unwrap();
    queue.submit([encoder.finish()]);
    stepper.settle().unwrap();
    if !judged {
        return Vec::new();
    }
    gimage_runtime::read_back(device, queue, &stepper.buffers(0).unwrap().now).unwrap()
}

fn judge(walk: &mut Walk, cloth: &Cloth, skin: &Skin, at: (&[[f64; 16]], &[[f32; 16]]), positions: &[[f32; 4]]) {
    let (worlds, matrices) = at;
    assert!(positions.iter().flatten().all(|x| x.is_finite()));
    let mut placed = cloth.clone();
    placed.follow_joints(matrices).unwrap();
    let mut points = Vec::new();
    for (piece, grid) in cloth.grids().iter().enumerate() {
        for k in grid.range().filter(|k| cloth.particles()[*k].exists()) {
            let p = [0, 1, 2].map(|c| f64::from(positions[k][c]));
            let skinned = placed.positions()[k];
            let far = (0..3).map(|c| (p[c] - f64::from(skinned[c])).powi(2)).sum::<f64>().sqrt();
            walk.astray[piece] = walk.astray[piece].max(far);
            if cloth.particles()[k].is_pinned() {
                assert!(far < 1e-5, "a pin is {far} m off the skin");
            } else {
                points.push(p);
            }
        }
    }
    // Both sides of a seam are one point.
    let (starts, members) = cloth.rings();
    for ring in starts.windows(2).map(|r| &members[r[0] as usize..r[1] as usize]) {
        let first = positions[ring[0] as usize];
        assert!(ring.iter().all(|k| positions[*k as usize][..3] == first[..3]), "a seam is open");
    }
    let depths = skin.depths(worlds, &points);
    walk.deep_frames += f64::from(u8::from(depths.iter().any(|d| *d > 1e-3)));
    walk.depths.extend(depths);
}

#[test]
fn the_default_rule_dresses_the_figure() {
    let manifest = &BUILT.bundle.manifest;
    let names: Vec<&str> = manifest.pieces.iter().map(|p| p.name.as_str()).collect();
    assert_eq!(names, ["Skirt", "T-shirt"]);
    assert!((20..=48).contains(&manifest.colliders.len()), "{} colliders", manifest.colliders.len());
    assert!(BUILT.bundle.body.is_none());
    let body = ON_SURFACE.bundle.body.as_ref().unwrap();
    assert_eq!((body.positions.len(), body.triangles.len(), body.sets()), (7662, 15320, 1), "as the file has them");
    let warnings: Vec<_> =
        BUILT.report.findings.iter().filter(|f| f.severity == gimage::record::Severity::Warning).collect();
    assert!(warnings.is_empty(), "{warnings:?}");
}

/// Checks a walk, also that 99.9 % of the particles, and all, are not deeper than `within` \[m\].
fn check(walk: &Walk, within: [f64; 2]) {
    let mm = |x: f64| 1e3 * x;
    let figures = format!(
        "depth 95 % {:.2}, 99.9 % {:.2}, max {:.2} mm; {:.0} % of frames deeper than 1 mm; stretch p99 {:.3}, max {:.3}; astray {:?} m",
        mm(walk.depth(0.95)),
        mm(walk.depth(0.999)),
        mm(walk.depth(1.0)),
        100.0 * walk.deep_frames,
        walk.stretch[0],
        walk.stretch[1],
        walk.astray
    );
    println!("{figures}");
    assert!(walk.depth(0.95) < 1e-3 && walk.depth(0.999) < within[0] && walk.depth(1.0) < within[1], "{figures}");
    assert!(walk.stretch[0] < 0.06, "{figures}");
    // The hem of a skirt swings; a T-shirt stays on its body.
    assert!(walk.astray[0] < 0.35 && walk.astray[1] < 0.12, "{figures}");
}

#[test]
fn the_figure_walks_in_its_clothes() {
    check(&walk(&BUILT, WALK, 2, None), [8e-3, 0.02]);
    let cpu = walk(&ON_SURFACE, WALK, 2, None);
    check(&cpu, [5e-4, 0.01]);
    assert!(cpu.deep_frames < 0.3, "{}", cpu.deep_frames);
    let Some(device) = adapter::device() else { return };
    let gpu = walk(&ON_SURFACE, 1.0, 2, Some(&device));
    check(&gpu, [5e-4, 0.01]);
    assert!(gpu.deep_frames < 0.3, "{}", gpu.deep_frames);
}

#[test]
fn the_host_program_plays_the_figure() {
    if adapter::device().is_none() {
        return;
    }
    let folder = tempfile::tempdir().unwrap();
    let path = folder.path().join("figure.gim");
    write_dir(&BUILT.bundle, &path, false).unwrap();
    let pixels = character::run(&path, &asset("figure.glb"), "Walk", 20).unwrap();
    let drawn = pixels.iter().filter(|p| p[..3] != [255; 3]).count() as f64 / pixels.len() as f64;
    assert!((0.1..0.8).contains(&drawn), "{drawn} of the picture is drawn");
    assert!(character::main().is_err(), "no bundle is given");
    assert!(character::run(&path, &asset("figure.glb"), "Swim", 1).is_err());
}

#[test]
fn a_surface_is_drawn_in_place_of_a_cloth_and_a_collider() {
    let mut scene = Scene::new("surface");
    scene.cloths.push(Flat::square("sheet", 5).cloth().unwrap());
    scene.colliders.push(Collider::new(Shape::Sphere { radius: 0.3 }, [0.0; 3]));
    let stepper = Stepper::on_cpu(scene, Options::default()).unwrap();
    let mut painter = Software::new(32, 32, 1).unwrap();
    let camera = Camera { eye: [0.0, 0.0, 3.0], target: [0.0; 3], fov: 0.6 };
    let view = View { background: [1.0; 3], ..View::new(&camera, 1.0) };
    let drawn = |painter: &Software| painter.picture(&stepper, &view, 1.0).unwrap();
    let before = drawn(&painter);
    painter.hidden.colliders.insert(0);
    painter.hidden.cloths.insert(0);
    assert!(drawn(&painter).iter().all(|p| *p == [255; 4]), "nothing is left to draw");
    let corners = [[-0.5, -0.5, 0.0], [0.5, -0.5, 0.0], [0.0, 0.5, 0.0]];
    painter.set_paints(vec![Paint::plain([0.9, 0.1, 0.1])]);
    let (normals, uv, colors) = ([[0.0, 0.0, 1.0]; 3], [[0.0; 2]; 3], [[1.0; 4]; 3]);
    painter.set_surface(vec![Facet { corners, normals, uv, colors, paint: 0 }]);
    let middle = drawn(&painter)[16 * 32 + 16];
    assert!(middle[0] > 150 && middle[1] < 80 && middle[2] < 80, "{middle:?}");
    painter.set_surface(Vec::new());
    painter.hidden = Hidden::default();
    assert_eq!(drawn(&painter), before);
}

#[test]
fn a_bundle_keeps_the_surface_of_the_body_and_names_what_is_wrong_with_it() {
    let files = ON_SURFACE.bundle.encode().unwrap();
    let read = gimage_bundle::Bundle::from_files(&files).unwrap();
    assert_eq!(read.body, ON_SURFACE.bundle.body);
    assert!(gimage_bundle::validate(&read).is_empty());

    let mut wrong = read.clone();
    wrong.body.as_mut().unwrap().triangles[7][1] = u32::MAX >> 9;
    assert!(gimage_bundle::validate(&wrong).iter().any(|fault| fault.message.contains("triangle 7")));
    let mut files = files;
    *files.get_mut("body_weights.exr").unwrap() = files["body_joints.exr"].clone();
    assert!(gimage_bundle::Bundle::from_files(&files).is_err(), "a file is not the one that was written");
    files.remove("body_weights.exr");
    assert!(gimage_bundle::Bundle::from_files(&files).is_err());

    let without = &BUILT.bundle;
    assert!(without.body.is_none() && !without.encode().unwrap().contains_key("body_position.exr"));
    let all = |bundle| BodyCollider::of_bundle(bundle).iter().map(|b| b.collider.collision_groups).collect::<Vec<_>>();
    assert!(all(without).iter().all(|groups| *groups == u32::MAX), "the cloth meets its solids");
    assert!(all(&ON_SURFACE.bundle).iter().all(|groups| *groups == gimage_runtime::BODY_GROUP));
}
