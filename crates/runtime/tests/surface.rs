//! Cloth on the surface of a body: it stays outside, at rest and in motion, with the same bits for any number of threads and from a saved state.

use std::sync::Arc;

use crate::support::limb::{IDENTITY, THICKNESS, depth, limb};
use crate::support::rig::{FRAME, Rig, largest};
use crate::support::{self, scene, tube};
use gimage_runtime::*;
use parry3d_f64::math::Vector;
use parry3d_f64::shape::{TriMesh, TriMeshFlags};

/// The weights of two joints, which meet at an elbow.
fn influence(p: &[f32; 3]) -> Influence {
    let second = ((-0.15 - p[1]) / 0.1).clamp(0.0, 1.0);
    Influence { joints: [0, 1, 0, 0], weights: [1.0 - second, second, 0.0, 0.0] }
}

/// The matrices of a shoulder that swings and an elbow that bends at a time.
fn pose(time: f32) -> Vec<[f32; 16]> {
    let turn = |angle: f32, height: f32, shift: f32| {
        let (s, c) = angle.sin_cos();
        [c, s, 0.0, 0.0, -s, c, 0.0, 0.0, 0.0, 0.0, 1.0, 0.0, s * height, height - c * height, shift, 1.0]
    };
    let times = |a: &[f32; 16], b: &[f32; 16]| -> [f32; 16] {
        std::array::from_fn(|n| (0..4).map(|k| a[4 * k + n % 4] * b[n / 4 * 4 + k]).sum())
    };
    let shoulder = turn(0.5 * (4.0 * time).sin(), 0.1, 0.3 * (2.0 * time).sin());
    vec![shoulder, times(&shoulder, &turn(0.9 * (5.0 * time).sin(), -0.2, 0.0))]
}

fn arm(radius: f32) -> (Vec<[f32; 3]>, Vec<[u32; 3]>) {
    // Longer than the sleeve, which would slip off its end.
    limb(radius, [0.15, -1.2], 24, 80)
}

/// A sleeve with a seam, pinned at its upper end, on an arm.
fn sleeve(radius: f32) -> Cloth {
    sleeve_of(tube(25, 20, 1), 25, radius)
}

/// One of a tube, of which these are the particles of a ring.
fn sleeve_of(mut cloth: Cloth, ring: u32, radius: f32) -> Cloth {
    cloth.pin(&(0..ring).collect::<Vec<_>>()).unwrap();
    let joint = |n: usize| SkinJoint { name: format!("joint {n}"), inverse_bind: IDENTITY, ..SkinJoint::default() };
    let list: Vec<_> = cloth.positions().iter().map(influence).collect();
    cloth.set_skin((0..2).map(joint).collect(), &list).unwrap();
    let (positions, triangles) = arm(radius);
    let influences = positions.iter().map(influence).collect();
    cloth.set_body(Some(Arc::new(BodySurface::new(positions, triangles, influences).unwrap()))).unwrap();
    cloth.thickness = Some(THICKNESS);
    cloth.damping = 0.5;
    cloth.follow_joints(&pose(0.0)).unwrap();
    cloth
}

/// Half the distance between opposite vertices of the sleeve.
fn girth() -> f32 {
    let cloth = tube(25, 20, 1);
    cloth.positions().iter().take(25).map(|p| (p[0] * p[0] + p[2] * p[2]).sqrt()).fold(f32::INFINITY, f32::min)
}

/// The arm as parry has it, where the joints put it.
fn judge(radius: f32, matrices: &[[f32; 16]]) -> TriMesh {
    let (positions, triangles) = arm(radius);
    let moved = |p: &[f32; 3]| {
        let own = influence(p);
        let at = |r: usize| {
            let by = |m: &[f32; 16]| m[r] * p[0] + m[4 + r] * p[1] + m[8 + r] * p[2] + m[12 + r];
            f64::from((0..2).map(|k| own.weights[k] * by(&matrices[k])).sum::<f32>())
        };
        Vector::new(at(0), at(1), at(2))
    };
    TriMesh::with_flags(positions.iter().map(moved).collect(), triangles, TriMeshFlags::ORIENTED).unwrap()
}

#[test]
fn a_sleeve_stays_outside_of_an_arm_that_swings_and_bends() {
    let radius = 0.85 * girth();
    let cloth = sleeve(radius);
    let mut stepper = Stepper::on_cpu(scene(cloth.clone()), Options::default()).unwrap();
    assert!(stepper.warnings().is_empty());
    let (mut nearest, mut deepest) = (f64::INFINITY, Vec::new());
    for frame in 1..=240 {
        let matrices = pose(frame as f32 * FRAME as f32);
        stepper.set_joints(0, &matrices).unwrap();
        stepper.advance(FRAME).unwrap();
        let now = stepper.positions(0).unwrap();
        let [deep, near] = depth(&judge(radius, &matrices), &cloth, now);
        (nearest, _) = (nearest.min(near), deepest.push(deep));
        let (starts, members) = cloth.rings();
        for ring in starts.windows(2).map(|r| &members[r[0] as usize..r[1] as usize]) {
            assert!(ring.iter().all(|k| now[*k as usize] == now[ring[0] as usize]), "a seam is open");
        }
    }
    deepest.sort_by(f64::total_cmp);
    // In the bend of the elbow cloth is squeezed between two sides.
    assert!(deepest[234] < 1e-3 && deepest[239] < 0.01, "{:?}", &deepest[220..]);
    assert!(nearest < 0.004, "the sleeve lies on the arm: {nearest}");

    // Without the surface it would not.
    let mut bare = cloth.clone();
    bare.set_body(None).unwrap();
    let mut stepper = Stepper::on_cpu(scene(bare), Options::default()).unwrap();
    let mut deep = 0.0f64;
    for frame in 1..=60 {
        let matrices = pose(frame as f32 * FRAME as f32);
        stepper.set_joints(0, &matrices).unwrap();
        stepper.advance(FRAME).unwrap();
        deep = deep.max(depth(&judge(radius, &matrices), &cloth, stepper.positions(0).unwrap())[0]);
    }
    assert!(deep > 0.01, "{deep}");
}

#[test]
fn cloth_that_falls_on_a_body_at_rest_lies_on_it_as_on_a_ball() {
    let (positions, triangles) = limb(0.2, [0.2, -0.2], 64, 48);
    let mesh = TriMesh::with_flags(
        positions.iter().map(|p| Vector::from_array(p.map(f64::from))).collect(),
        triangles.clone(),
        TriMeshFlags::ORIENTED,
    );
    let mut cloth = Flat { origin: [-0.5, 0.3, -0.5], ..Flat::square("sheet", 33) }.cloth().unwrap();
    cloth.thickness = Some(THICKNESS);
    let plain = cloth.clone();
    cloth.set_body(Some(Arc::new(BodySurface::new(positions, triangles, Vec::new()).unwrap()))).unwrap();
    let mut stepper = Stepper::on_cpu(scene(cloth.clone()), Options::default()).unwrap();
    (0..90).for_each(|_| _ = stepper.advance(FRAME).unwrap());
    let [deep, near] = depth(&mesh.unwrap(), &cloth, stepper.positions(0).unwrap());
    assert!(deep < 1e-3 && near < 0.004, "{deep}, {near}");

    // Far from a body the bits are those without a body, given the same numbers of steps.
    let options = Options { substeps: Some(8), polish: Some(2), ..Options::default() };
    let far = |mut cloth: Cloth| {
        cloth.place(cloth.positions().iter().map(|p| [p[0], p[1] + 50.0, p[2]]).collect()).unwrap();
        let mut stepper = Stepper::on_cpu(scene(cloth), options.clone()).unwrap();
        (0..20).for_each(|_| _ = stepper.advance(FRAME).unwrap());
        stepper.positions(0).unwrap().to_vec()
    };
    assert_eq!(far(cloth), far(plain));
}

#[test]
fn any_number_of_threads_and_a_saved_state_give_the_same_bits() {
    let cloth = sleeve(0.85 * girth());
    let start = |threads| {
        let mut two = scene(cloth.clone());
        two.cloths.push(cloth.clone());
        Stepper::on_cpu(two, Options { threads, ..Options::default() }).unwrap()
    };
    let go = |stepper: &mut Stepper, frames: std::ops::RangeInclusive<u32>| {
        for frame in frames {
            (0..2).for_each(|cloth| stepper.set_joints(cloth, &pose(frame as f32 * FRAME as f32)).unwrap());
            stepper.advance(FRAME).unwrap();
        }
    };
    let mut one = start(1);
    go(&mut one, 1..=40);
    let mut many = start(3);
    go(&mut many, 1..=40);
    assert_eq!(one.positions(1), many.positions(1));

    let saved = one.snapshot().unwrap();
    let mut other = start(1);
    other.restore(&saved).unwrap();
    (0..2).for_each(|cloth| other.teleport_joints(cloth, &pose(40.0 * FRAME as f32)).unwrap());
    go(&mut one, 41..=80);
    go(&mut other, 41..=80);
    assert_eq!(one.positions(0), other.positions(0));
    assert_ne!(one.positions(0), many.positions(0));
}

#[test]
fn a_cloth_on_a_surface_meets_no_collider_that_stands_for_the_body() {
    let (mut positions, triangles) = limb(0.2, [0.2, -0.2], 16, 12);
    positions.iter_mut().for_each(|p| p[0] += 10.0);
    let mut cloth = Flat::square("sheet", 9).cloth().unwrap();
    cloth.set_body(Some(Arc::new(BodySurface::new(positions, triangles, Vec::new()).unwrap()))).unwrap();
    let floor = |groups| Collider { collision_groups: groups, ..Collider::new(Shape::HalfSpace, [0.0, -0.3, 0.0]) };
    let end = |cloth: Cloth, groups| {
        let mut scene = scene(cloth);
        scene.colliders.push(floor(groups));
        let mut stepper = Stepper::on_cpu(scene, Options { substeps: Some(8), ..Options::default() }).unwrap();
        (0..30).for_each(|_| _ = stepper.advance(FRAME).unwrap());
        stepper.positions(0).unwrap().iter().fold(f32::INFINITY, |low, p| low.min(p[1]))
    };
    let mut bare = cloth.clone();
    bare.set_body(None).unwrap();
    let lowest = [end(cloth.clone(), BODY_GROUP), end(cloth, u32::MAX), end(bare, BODY_GROUP)];
    assert!(lowest[0] < -0.32, "the surface is met in place of it: {lowest:?}");
    assert!(lowest[1] > -0.31 && lowest[2] > -0.31, "others are met: {lowest:?}");
}

#[test]
fn what_does_not_collide_with_surfaces_says_so() {
    let cloth = sleeve(0.8 * girth());
    let left_out = |stepper: &Stepper| {
        let found = stepper.warnings().iter().any(|w| matches!(w, Warning::BodyLeftOut { .. }));
        assert_eq!(found, stepper.scene().cloths[0].body().is_none());
        found
    };
    assert!(!left_out(&Stepper::on_cpu(scene(cloth.clone()), Options::default()).unwrap()));
    let mut still = cloth.clone();
    still.set_skin(vec![SkinJoint::default(); 2], &vec![influence(&[0.0; 3]); cloth.len()]).unwrap();
    let classic = Options { solver: Solver::Classic, ..Options::default() };
    let mut stepper = Stepper::on_cpu(scene(still.clone()), classic.clone()).unwrap();
    assert!(left_out(&stepper));
    let added = stepper.add_cloth(still.clone()).unwrap();
    assert!(stepper.scene().cloths[1].body().is_none());
    assert_eq!(stepper.warnings().len(), 2);
    stepper.remove_cloth(added).unwrap();
    let Some(device) = support::device() else { return };
    assert!(left_out(&Rig::gpu(scene(still), &classic, &device).stepper));
    assert!(!left_out(&Rig::gpu(scene(cloth), &Options::default(), &device).stepper));
}

/// A frame, which the joints of cloths that follow any end in their pose.
fn swing(rig: &mut Rig, frame: u32) {
    for cloth in 0..rig.stepper.scene().cloths.len() {
        if rig.stepper.scene().cloths[cloth].follows_joints() {
            rig.stepper.set_joints(cloth, &pose(frame as f32 * FRAME as f32)).unwrap();
        }
    }
    rig.frame(FRAME);
}

/// A sheet too large for a workgroup above a body at rest.
fn sheet() -> Cloth {
    let (positions, triangles) = limb(0.2, [0.2, -0.2], 64, 48);
    let mut cloth = Flat { origin: [-0.5, 0.22, -0.5], ..Flat::square("sheet", 70) }.cloth().unwrap();
    cloth.thickness = Some(THICKNESS);
    cloth.set_body(Some(Arc::new(BodySurface::new(positions, triangles, Vec::new()).unwrap()))).unwrap();
    cloth
}

fn fixed() -> Options {
    Options { substeps: Some(8), polish: Some(1), ..Options::default() }
}

/// How far a squeezed cloth may be from its twin on a device after some frames: `exact` where cloth without a body has the bits of the twin. Other
/// devices round otherwise, and squeezed cloth doubles the difference every few steps: there it is four times as far as a thousandth of
/// gravity moves it on the CPU.
fn squeezed(device: &(wgpu::Device, wgpu::Queue), like: &Scene, frames: u32, exact: f32) -> f32 {
    let mut bare = scene(sleeve(0.85 * girth()));
    bare.cloths[0].set_body(None).unwrap();
    let mut rigs = [Rig::cpu(bare.clone(), &fixed()), Rig::gpu(bare, &fixed(), device)];
    rigs.iter_mut().for_each(|rig| (1..=3).for_each(|n| swing(rig, n)));
    if rigs[0].positions(0) == rigs[1].positions(0) {
        return exact;
    }
    let end = |heavier: f32| {
        let gravity = like.gravity.map(|g| g * heavier);
        let mut rig = Rig::cpu(Scene { gravity, ..like.clone() }, &fixed());
        (1..=frames).for_each(|n| swing(&mut rig, n));
        rig.positions(0)
    };
    4.0 * largest(&end(1.0), &end(1.001))
}

#[test]
fn a_frame_from_one_state_is_that_of_the_twin() {
    let Some(device) = support::device() else { return };
    for skinning in [Skinning::Linear, Skinning::DualQuaternion] {
        let mut cloth = sleeve(0.85 * girth());
        cloth.skinning = skinning;
        let mut rigs = [Rig::cpu(scene(cloth.clone()), &fixed()), Rig::gpu(scene(cloth.clone()), &fixed(), &device)];
        let mut far = [Vec::new(), Vec::new()];
        for frame in 1..=60 {
            // Both from where the CPU is, then each from where it is itself, by what its particles know of the last frame.
            if frame <= 30 {
                let state = rigs[0].stepper.snapshot().unwrap();
                rigs[1].stepper.restore(&state).unwrap();
                rigs[1].stepper.teleport_joints(0, &pose((frame - 1) as f32 * FRAME as f32)).unwrap();
            }
            rigs.iter_mut().for_each(|rig| swing(rig, frame));
            far[usize::from(frame > 30)].push(largest(&rigs[0].positions(0), &rigs[1].positions(0)));
        }
        let most = |list: &[f32]| list.iter().copied().fold(0.0, f32::max);
        // Rounding grows where cloth is squeezed.
        let [first, second, then] = [most(&far[0][..4]), most(&far[0][4..]), most(&far[1][..10])];
        // The sleeve is pressed together in the first frames.
        let within = squeezed(&device, &scene(cloth), 4, 1e-6);
        let settled = if within > 1e-6 { [1e-4, 2e-4] } else { [1e-6, 1e-5] };
        assert!(first <= within && second < settled[0] && then < settled[1], "{far:?} {within}");
    }
}

#[test]
fn every_form_has_the_same_contact_with_a_body() {
    let Some(device) = support::device_with(device_limits) else { return };
    // A skin that no joints move leaves the surface at rest.
    let mut still = sleeve(0.85 * girth());
    let influences: Vec<_> = still.positions().iter().map(influence).collect();
    still.set_skin(vec![SkinJoint::default(); 2], &influences).unwrap();
    assert!(!still.follows_joints() && still.body().is_some());
    let fine = sleeve_of(tube(121, 28, 1), 121, 0.85 * girth());
    for (cloth, whole) in [(sleeve(0.85 * girth()), true), (still, true), (sheet(), false), (fine, false)] {
        // Both in one buffer.
        let scene = Scene { cloths: vec![cloth.clone(), cloth], ..Scene::new("two") };
        let run = |fused| {
            let mut rig = Rig::gpu(scene.clone(), &Options { fused, ..fixed() }, &device);
            let plan = rig.stepper.plan();
            let holds = plan.passes.iter().filter(|p| matches!(p.form, Form::Whole(_))).count();
            let tiles = plan.passes.iter().filter(|p| matches!(p.form, Form::Tile(_))).count();
            (1..9).for_each(|n| swing(&mut rig, n));
            assert!(rig.positions(0) == rig.positions(1));
            (holds > 0, tiles > 0, rig.positions(1))
        };
        let (fused, apart, again) = (run(true), run(false), run(true));
        assert_eq!((fused.0, fused.1, apart.0, apart.1), (whole, !whole, false, false));
        assert!(fused.2 == again.2);
        let mut cpu = Rig::cpu(scene.clone(), &fixed());
        (1..9).for_each(|n| swing(&mut cpu, n));
        let [far, of_twin] = [&apart.2, &cpu.positions(1)].map(|other| largest(other, &fused.2));
        let within = if support::alike::tolerates(&device) { 1e-4 } else { 0.0 };
        // The sheet is not squeezed.
        let twin_within =
            if scene.cloths[0].follows_joints() || whole { squeezed(&device, &scene, 8, 1e-5) } else { 1e-5 };
        assert!(far <= within && of_twin < twin_within, "{far}, {of_twin} of {twin_within}");
        let mut free = scene.clone();
        free.cloths[0].set_body(None).unwrap();
        let mut rig = Rig::gpu(free, &fixed(), &device);
        (1..9).for_each(|n| swing(&mut rig, n));
        assert!(rig.positions(1) == fused.2, "what lies beside it changes nothing");
        assert!(largest(&rig.positions(0), &fused.2) > 1e-3, "there is contact");
        // One that comes later takes a place beside them.
        let added = rig.stepper.add_cloth(scene.cloths[0].clone()).unwrap();
        rig.frames(3);
        assert!(rig.positions(2).iter().flatten().all(|x| x.is_finite()));
        rig.stepper.remove_cloth(added).unwrap();
    }
}

#[test]
fn a_sleeve_stays_outside_of_an_arm_on_the_gpu() {
    let Some(device) = support::device() else { return };
    let radius = 0.85 * girth();
    let cloth = sleeve(radius);
    let mut rig = Rig::gpu(scene(cloth.clone()), &Options::default(), &device);
    assert!(rig.stepper.warnings().is_empty());
    let (mut nearest, mut deepest) = (f64::INFINITY, Vec::new());
    let mut saved = None;
    for frame in 1..=120 {
        swing(&mut rig, frame);
        let now = rig.positions(0);
        let [deep, near] = depth(&judge(radius, &pose(frame as f32 * FRAME as f32)), &cloth, &now);
        (nearest, _) = (nearest.min(near), deepest.push(deep));
        if frame == 90 {
            saved = Some(rig.stepper.snapshot().unwrap());
        }
    }
    let mut other = Rig::gpu(scene(cloth), &Options::default(), &device);
    other.stepper.restore(&saved.unwrap()).unwrap();
    other.stepper.teleport_joints(0, &pose(90.0 * FRAME as f32)).unwrap();
    (91..=120).for_each(|frame| swing(&mut other, frame));
    assert!(rig.positions(0) == other.positions(0), "a saved state goes on with the same bits");
    deepest.sort_by(f64::total_cmp);
    assert!(deepest[116] < 1e-3 && deepest[119] < 0.01, "{:?}", &deepest[110..]);
    assert!(nearest < 0.004, "the sleeve lies on the arm: {nearest}");
}

#[test]
fn cloth_with_contact_meets_a_body_in_its_own_passes() {
    let Some(device) = support::device() else { return };
    let mut cloth = sleeve(0.85 * girth());
    cloth.contact = Some(ClothContact { distance: Some(0.004), ..ClothContact::default() });
    // Another one far away, so that their steps go together.
    let mut other = Flat { origin: [5.0, 0.0, 0.0], ..Flat::square("other", 9) }.cloth().unwrap();
    other.contact = cloth.contact;
    let scene = Scene { cloths: vec![cloth, other], ..Scene::new("two") };
    let mut rigs = [Rig::cpu(scene.clone(), &fixed()), Rig::gpu(scene.clone(), &fixed(), &device)];
    let own = |rig: &Rig| rig.stepper.plan().passes.iter().any(|p| p.form.pass() == Some(Pass::SurfaceContact));
    assert!(rigs.iter().all(own));
    // In the third frame the backends part in contact of cloth with cloth, with a body and without.
    (1..3).for_each(|frame| rigs.iter_mut().for_each(|rig| swing(rig, frame)));
    let far = largest(&rigs[0].positions(0), &rigs[1].positions(0));
    let within = squeezed(&device, &scene, 2, 1e-5);
    assert!(far < within, "{far} of {within}");
}

#[test]
fn contact_with_a_body_costs_nothing_without_one() {
    let cloth = sleeve(0.85 * girth());
    let surface = cloth.body().unwrap().clone();
    let mut bare = cloth.clone();
    bare.set_body(None).unwrap();
    // Cloth in contact has tethers at other places of a step.
    let options = Options { tethers: 0, ..fixed() };
    let plan = |cloth: &Cloth| Stepper::on_cpu(scene(cloth.clone()), options.clone()).unwrap().plan();
    let (with, without) = (plan(&cloth), plan(&bare));
    let own = |plan: &Plan| -> Vec<(&str, u32)> {
        let own = plan.passes.iter().filter(|p| p.shader.starts_with("surface"));
        own.map(|p| (p.shader, p.dispatches)).collect()
    };
    assert_eq!(own(&without), []);
    let passes = [("surface_pose", 1), ("surface_boxes", 1), ("surface_search", 1), ("surface_contact", 8)];
    assert_eq!(own(&with), passes);
    assert_eq!(with.dispatches() - without.dispatches(), 11);
    let slots = ["surface_planes", "surface_shape", "surface_vertices", "surface_hints", "wearers", "found_planes"];
    let bytes = |plan: &Plan, name: &str| -> Option<u64> {
        plan.passes.iter().flat_map(|p| &p.bindings).find(|b| b.0 == name).map(|b| b.1)
    };
    assert!(slots.iter().all(|slot| bytes(&without, slot).is_none()));
    let (n, v) = (cloth.len() as u64, surface.vertices() as u64);
    let want = [128 * n, 64 * v, 64 * v, 80 * n, 64 * n, 128 * n].map(Some);
    assert_eq!(slots.map(|slot| bytes(&with, slot)), want);
}

#[test]
fn surfaces_that_break_a_rule_are_refused() {
    let (positions, triangles) = limb(0.1, [0.2, -0.2], 8, 8);
    let refused = |positions: &[[f32; 3]], triangles: &[[u32; 3]], influences: Vec<Influence>| {
        let made = BodySurface::new(positions.to_vec(), triangles.to_vec(), influences);
        assert!(matches!(made, Err(Error::Surface { .. })), "{made:?}");
    };
    let mut bad = positions.clone();
    bad[3][1] = f32::NAN;
    refused(&bad, &triangles, Vec::new());
    refused(&positions, &[[0, 1, 9999]], Vec::new());
    refused(&positions, &[[0, 0, 1]], Vec::new());
    refused(&positions, &triangles, vec![Influence::default(); 3]);
    refused(&positions, &triangles, vec![Influence::default(); positions.len()]);
    let one = Influence { joints: [5, 0, 0, 0], weights: [1.0, 0.0, 0.0, 0.0] };
    let surface = BodySurface::new(positions.clone(), triangles, vec![one; positions.len()]).unwrap();
    assert_eq!((surface.vertices(), surface.triangles().len()), (66, 8 * 7 * 2 + 16));
    let mut cloth = sleeve(0.5 * girth());
    assert!(matches!(cloth.set_body(Some(Arc::new(surface))), Err(Error::Surface { index: 5, .. })));
    assert!(cloth.body().is_some(), "it keeps what it had");
}
