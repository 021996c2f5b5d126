//! Cloth that follows joints: pins on the skin, limits around it, the same on every backend and in every form.

use crate::support::rig::{FRAME, Rig, largest};
use crate::support::{self, scene, tube};
use gimage_runtime::scene::{Pose, about};
use gimage_runtime::*;

/// The transform of a chain's joint to world space, in f64: a turn about z at a point, after that of its parent.
type Matrix = [[f64; 4]; 3];

fn times(a: &Matrix, b: &Matrix) -> Matrix {
    let last = [0.0, 0.0, 0.0, 1.0];
    let row = |r: &[f64; 4], c: usize| (0..4).map(|k| r[k] * b.get(k).unwrap_or(&last)[c]).sum();
    [0, 1, 2].map(|r| [0, 1, 2, 3].map(|c| row(&a[r], c)))
}

/// A turn about z by an angle at a height, then a shift along z.
fn turn(angle: f64, height: f64, shift: f64) -> Matrix {
    let (s, c) = angle.sin_cos();
    [[c, -s, 0.0, s * height], [s, c, 0.0, height - c * height], [0.0, 0.0, 1.0, shift]]
}

/// Joint matrices of a chain of three joints along a sleeve at a time, which bends and swings.
fn pose(time: f64) -> Vec<Matrix> {
    let swing = (5.0 * time).sin();
    let root = turn(0.4 * swing, 0.0, 0.3 * (3.0 * time).sin());
    let elbow = times(&root, &turn(0.8 * swing, -0.2, 0.0));
    let hand = times(&elbow, &turn(0.5 * swing, -0.4, 0.0));
    vec![root, elbow, hand]
}

fn columns(matrices: &[Matrix]) -> Vec<[f32; 16]> {
    let one =
        |m: &Matrix| std::array::from_fn(|n| if n % 4 == 3 { f32::from(n == 15) } else { m[n % 4][n / 4] as f32 });
    matrices.iter().map(one).collect()
}

/// The weights of the three joints at a height: linear between them.
fn weights(y: f64) -> [f64; 3] {
    let along = (-y / 0.2).clamp(0.0, 2.0);
    [0.0, 1.0, 2.0].map(|n: f64| (1.0 - (along - n).abs()).max(0.0))
}

fn skinned(rest: [f32; 3], matrices: &[Matrix]) -> [f64; 3] {
    let p = rest.map(f64::from);
    let at = |m: &Matrix, r: usize| m[r][0] * p[0] + m[r][1] * p[1] + m[r][2] * p[2] + m[r][3];
    let w = weights(p[1]);
    [0, 1, 2].map(|r| matrices.iter().zip(w).map(|(m, w)| w * at(m, r)).sum())
}

/// Gives a cloth the chain, and has it follow the chain from its pose at time 0.
fn follow(cloth: &mut Cloth) {
    let joint = |n: usize| SkinJoint { name: format!("joint {n}"), ..SkinJoint::default() };
    let of = |p: &[f32; 3]| {
        let [a, b, c] = weights(f64::from(p[1])).map(|w| w as f32);
        Influence { joints: [0, 1, 2, 0], weights: [a, b, c, 0.0] }
    };
    let list: Vec<_> = cloth.positions().iter().map(of).collect();
    cloth.set_skin((0..3).map(joint).collect(), &list).unwrap();
    cloth.follow_joints(&columns(&pose(0.0))).unwrap();
}

/// A tube with a seam whose first and last rows are pinned.
fn sleeve() -> Cloth {
    let mut cloth = tube(17, 12, 1);
    let ends: Vec<u32> = (0..204).filter(|k| k / 17 == 0 || k / 17 == 11).collect();
    cloth.pin(&ends).unwrap();
    follow(&mut cloth);
    cloth
}

/// A sheet too large for a workgroup, pinned along its upper row.
fn sheet(n: u32) -> Cloth {
    let flat = Flat { down: [0.0, -0.4, 0.0], ..Flat::square("sheet", n) };
    let mut cloth = flat.cloth().unwrap();
    cloth.pin(&(0..n).collect::<Vec<_>>()).unwrap();
    follow(&mut cloth);
    cloth
}

fn frame(rig: &mut Rig, n: u32) {
    rig.stepper.set_joints(0, &columns(&pose(f64::from(n) * FRAME))).unwrap();
    rig.frame(FRAME);
}

/// The largest distance of a pinned particle from the skin [m].
fn off(cloth: &Cloth, rest: &[[f32; 3]], positions: &[[f32; 4]], matrices: &[Matrix]) -> f64 {
    let pinned = (0..cloth.len()).filter(|k| cloth.particles()[*k].is_pinned());
    let far = pinned.map(|k| {
        let to = skinned(rest[k], matrices);
        (0..3).map(|c| (f64::from(positions[k][c]) - to[c]).powi(2)).sum::<f64>().sqrt()
    });
    far.fold(0.0, f64::max)
}

#[test]
fn pins_stay_on_the_skin_and_seams_closed() {
    let cloth = sleeve();
    let rest = tube(17, 12, 1).positions().to_vec();
    for mut rig in Rig::both(&scene(cloth.clone()), &Options::default()) {
        for n in 1..60 {
            frame(&mut rig, n);
            let positions = rig.positions(0);
            let far = off(&cloth, &rest, &positions, &pose(f64::from(n) * FRAME));
            assert!(far < 1e-6, "{} frame {n}: {far} m", rig.name());
            for row in positions.chunks(17) {
                assert_eq!(row[0][..3], row[16][..3], "{} frame {n}", rig.name());
            }
        }
        assert!(largest(&rig.positions(0), &rig.previous(0)) < 0.1, "{}", rig.name());
    }
}

#[test]
fn a_sleeve_that_twists_by_half_a_turn_keeps_its_volume_by_dual_quaternions() {
    // The lower end is turned about y, and half as wide again.
    let lower = |angle: f64| -> Matrix {
        let (s, c) = angle.sin_cos();
        [[1.5 * c, 0.0, 1.5 * s, 0.0], [0.0, 1.5, 0.0, 0.275], [-1.5 * s, 0.0, 1.5 * c, 0.0]]
    };
    let still: Matrix = [[1.0, 0.0, 0.0, 0.0], [0.0, 1.0, 0.0, 0.0], [0.0, 0.0, 1.0, 0.0]];
    let share = |k: usize| (k / 17) as f32 / 11.0;
    for skinning in [Skinning::DualQuaternion, Skinning::Linear] {
        let mut cloth = tube(17, 12, 1);
        cloth.skinning = skinning;
        cloth.pin(&(0..204).collect::<Vec<_>>()).unwrap();
        let list: Vec<_> = (0..204)
            .map(|k| Influence { joints: [0, 1, 0, 0], weights: [1.0 - share(k), share(k), 0.0, 0.0] })
            .collect();
        cloth.set_skin(vec![SkinJoint::default(), SkinJoint::default()], &list).unwrap();
        cloth.follow_joints(&columns(&[still, lower(0.0)])).unwrap();
        for mut rig in Rig::both(&scene(cloth.clone()), &Options::default()) {
            for n in 1..=30 {
                let angle = std::f64::consts::PI * f64::from(n) / 30.0;
                rig.stepper.set_joints(0, &columns(&[still, lower(angle)])).unwrap();
                rig.frame(FRAME);
            }
            let radius = |p: &[f32; 4]| p[0].hypot(p[2]);
            let far = |(k, p): (usize, &[f32; 4])| (radius(p) - 0.2 * (1.0 + 0.5 * share(k))).abs();
            let off = rig.positions(0).iter().enumerate().map(far).fold(0.0, f32::max);
            match skinning {
                Skinning::DualQuaternion => assert!(off < 1e-5, "{}: {off} m", rig.name()),
                // Where the turned part of the mean cancels out the other one.
                Skinning::Linear => assert!(off > 0.15, "{}: {off} m", rig.name()),
            }
        }
    }
}

#[test]
fn pins_move_smoothly_within_a_frame_and_rest_after_it() {
    for mut rig in Rig::both(&scene(sleeve()), &Options { substeps: Some(8), ..Options::default() }) {
        frame(&mut rig, 1);
        let start = rig.positions(0);
        frame(&mut rig, 2);
        let (end, before) = (rig.positions(0), rig.previous(0));
        for k in 0..17 {
            for c in 0..3 {
                // An eighth of the way in the last of eight steps.
                let (way, step) = (end[k][c] - start[k][c], end[k][c] - before[k][c]);
                assert!((step - way / 8.0).abs() < 1e-6, "{} {k}: {step} of {way}", rig.name());
            }
        }
        // No matrices: the joints rest.
        rig.frame(FRAME);
        let (now, before) = (rig.positions(0), rig.previous(0));
        assert!((0..17).all(|k| now[k] == end[k] && now[k] == before[k]), "{}", rig.name());
        // A frame without a step moves nothing, and the next one goes all the way.
        rig.stepper.set_joints(0, &columns(&pose(0.5))).unwrap();
        rig.frame(FRAME / 100.0);
        rig.frame(FRAME);
        let (cloth, rest) = (sleeve(), tube(17, 12, 1).positions().to_vec());
        assert!(off(&cloth, &rest, &rig.positions(0), &pose(0.5)) < 1e-6, "{}", rig.name());
    }
}

#[test]
fn cloth_that_follows_no_joint_has_no_pass_and_no_bytes_for_it() {
    let plan = |cloth: Cloth| Rig::cpu(scene(cloth), &Options::default()).stepper.plan();
    let bare = {
        let mut cloth = tube(17, 12, 1);
        cloth.pin(&(0..17).collect::<Vec<_>>()).unwrap();
        cloth
    };
    let mut skinned = bare.clone();
    follow(&mut skinned);
    let following = plan(skinned.clone());
    let count = |plan: &Plan| plan.passes.iter().filter(|p| p.form.pass() == Some(Pass::Follow)).count();
    // A skin alone costs nothing.
    let joints = skinned.skin().unwrap().joints().to_vec();
    let mut idle = bare.clone();
    idle.set_skin(joints, &[Influence { joints: [0; 4], weights: [1.0, 0.0, 0.0, 0.0] }; 204]).unwrap();
    assert_eq!(plan(idle), plan(bare.clone()));
    assert_eq!((count(&plan(bare.clone())), count(&following)), (0, 1));
    // 16 bytes per particle for where each is to be, and for how fast it gets there.
    assert!(following.bytes() - plan(bare).bytes() >= 32 * 204);
}

#[test]
fn limits_are_distances_from_the_skin() {
    let mut cloth = tube(17, 12, 1);
    let rest = cloth.positions().to_vec();
    cloth.limits = Some((0..cloth.len()).map(|k| 0.01 * (k / 17) as f32).collect());
    follow(&mut cloth);
    for mut rig in Rig::both(&scene(cloth), &Options::default()) {
        let mut moved = 0.0f64;
        for n in 1..40 {
            frame(&mut rig, n);
            let (positions, matrices) = (rig.positions(0), pose(f64::from(n) * FRAME));
            for (k, p) in positions.iter().enumerate() {
                let to = skinned(rest[k], &matrices);
                let far = (0..3).map(|c| (f64::from(p[c]) - to[c]).powi(2)).sum::<f64>().sqrt();
                assert!(far <= 0.01 * (k / 17) as f64 + 2e-6, "{} frame {n}, {k}: {far}", rig.name());
                moved = moved.max(far);
            }
        }
        assert!(moved > 0.02, "limits leave room");
    }
}

#[test]
fn a_teleport_moves_the_joints_and_joints_can_be_put_elsewhere() {
    let by = Pose { position: [10.0, 2.0, -3.0], rotation: about([0.0, 1.0, 0.0], 1.0) };
    for mut rig in Rig::both(&scene(sleeve()), &Options::default()) {
        (1..5).for_each(|n| frame(&mut rig, n));
        let before = rig.positions(0);
        rig.stepper.teleport(0, &by).unwrap();
        rig.frame(FRAME);
        let (after, was) = (rig.positions(0), rig.previous(0));
        for k in 0..17 {
            let to = by.apply([before[k][0], before[k][1], before[k][2]]);
            assert!(
                (0..3).all(|c| (after[k][c] - to[c]).abs() < 4e-6),
                "{} {k}: {:?}, not {to:?}",
                rig.name(),
                after[k]
            );
            assert!((0..3).all(|c| (after[k][c] - was[k][c]).abs() < 4e-6), "{} {k}", rig.name());
        }
        // Put: there at once, at rest.
        rig.stepper.teleport_joints(0, &columns(&pose(0.1))).unwrap();
        rig.frame(FRAME);
        let (cloth, rest) = (sleeve(), tube(17, 12, 1).positions().to_vec());
        assert!(off(&cloth, &rest, &rig.positions(0), &pose(0.1)) < 1e-6, "{}", rig.name());
        assert!((0..17).all(|k| rig.positions(0)[k] == rig.previous(0)[k]), "{}", rig.name());
    }
}

#[test]
fn what_cannot_follow_is_refused() {
    let mut rig = Rig::cpu(scene(sleeve()), &Options::default());
    let still = columns(&pose(0.0));
    assert!(rig.stepper.set_joints(0, &still[..2]).unwrap_err().to_string().contains("2 joint matrices for 3"));
    let mut bad = still.clone();
    bad[1][4] = f32::NAN;
    assert!(rig.stepper.set_joints(0, &bad).unwrap_err().to_string().contains("joint 1"));
    // A pinned particle is where joints put it; once it is free the host may pin it again.
    let at = [[0.0; 3]];
    assert!(rig.stepper.set_pins(0, &[3], &at).unwrap_err().to_string().contains("particle 3 follows joints"));
    rig.stepper.set_pins(0, &[40], &at).unwrap();
    rig.stepper.unpin(0, &[3]).unwrap();
    rig.stepper.set_pins(0, &[3], &at).unwrap();
    let mut plain = Rig::cpu(scene(tube(17, 12, 1)), &Options::default());
    assert!(plain.stepper.set_joints(0, &still).unwrap_err().to_string().contains("follow_joints"));
    let classic = Options { solver: Solver::Classic, ..Options::default() };
    let mut classic = Rig::cpu(scene(sleeve()), &classic);
    assert!(classic.stepper.set_joints(0, &still).unwrap_err().to_string().contains("classic"));
}

#[test]
fn cloth_whose_joints_rest_falls_asleep_and_joints_wake_it() {
    let options = Options { sleep: Some(Sleep { speed: 0.5, after: 0.2 }), ..Options::default() };
    for mut rig in Rig::both(&scene(sleeve()), &options) {
        for _ in 0..120 {
            rig.stepper.set_joints(0, &columns(&pose(0.0))).unwrap();
            rig.frame_to_its_end(FRAME);
        }
        assert!(rig.stepper.is_asleep(0), "{}: equal matrices do not wake it", rig.name());
        rig.stepper.set_joints(0, &columns(&pose(0.1))).unwrap();
        assert!(!rig.stepper.is_asleep(0), "{}", rig.name());
    }
}

#[test]
fn a_hit_of_a_finer_level_is_refused_by_cloth_that_follows_joints() {
    let mut rig = Rig::cpu(scene(sheet(33)), &Options::default());
    let hit = Hit {
        cloth: 0,
        handle: None,
        grid: 0,
        texel: [9, 27],
        triangle: 1,
        particles: [900, 901, 934],
        barycentric: [1.0, 0.0, 0.0],
        corners: [[0.0; 3]; 3],
        distance: 1.0,
    };
    rig.stepper.set_level(0, 1).unwrap();
    assert!(matches!(rig.stepper.grab(&hit), Err(Error::NoSuch { .. })));
}

#[test]
fn states_and_levels_go_on_with_the_joints() {
    let cloth = sheet(33);
    let rest = Flat { down: [0.0, -0.4, 0.0], ..Flat::square("sheet", 33) }.cloth().unwrap().positions().to_vec();
    for mut rig in Rig::both(&scene(cloth.clone()), &Options::default()) {
        (1..10).for_each(|n| frame(&mut rig, n));
        let saved = rig.stepper.snapshot().unwrap();
        let (at, matrices) = (rig.positions(0), columns(&pose(9.0 * FRAME)));
        (10..20).for_each(|n| frame(&mut rig, n));
        let once = rig.positions(0);
        rig.stepper.restore(&saved).unwrap();
        rig.stepper.teleport_joints(0, &matrices).unwrap();
        (10..20).for_each(|n| frame(&mut rig, n));
        // To rounding: the first frame after it has its joints at rest before, not on their way.
        assert!(largest(&rig.positions(0), &once) < 1e-6, "{}", rig.name());
        assert!(largest(&at, &once) > 0.01, "{}", rig.name());
        rig.stepper.set_level(0, 1).unwrap();
        (20..25).for_each(|n| frame(&mut rig, n));
        let coarse = &rig.stepper.scene().cloths[0];
        let samples = rig.stepper.level_samples(0).unwrap();
        let coarse_rest: Vec<_> = samples.iter().map(|k| rest[*k as usize]).collect();
        assert_eq!(coarse.len(), 17 * 17);
        assert!(off(coarse, &coarse_rest, &rig.positions(0), &pose(24.0 * FRAME)) < 1e-6, "{}", rig.name());
        rig.stepper.set_level(0, 0).unwrap();
        (25..30).for_each(|n| frame(&mut rig, n));
        assert!(off(&cloth, &rest, &rig.positions(0), &pose(29.0 * FRAME)) < 1e-6, "{}", rig.name());
    }
}

#[test]
fn a_pin_of_the_host_stays_its_own_on_every_level() {
    for mut rig in Rig::both(&scene(sheet(33)), &Options::default()) {
        frame(&mut rig, 1);
        let (fine, coarse, at) = (16 * 33 + 16, 8 * 17 + 8, [0.1, -0.2, 0.3]);
        rig.stepper.pin(0, &[fine]).unwrap();
        rig.stepper.set_pins(0, &[fine], &[at]).unwrap();
        for (level, particle) in [(1, coarse), (0, fine)] {
            rig.stepper.set_level(0, level).unwrap();
            (2..6).for_each(|n| frame(&mut rig, n));
            let now = rig.positions(0)[particle as usize];
            assert_eq!((&now[..3], now[3]), (&at[..], 0.0), "{} level {level}: it stays while joints move", rig.name());
            rig.stepper.set_pins(0, &[particle], &[at]).unwrap();
            // Those on the skin are not the host's.
            assert!(matches!(rig.stepper.set_pins(0, &[0], &[at]), Err(Error::Follows { .. })));
        }
    }
}

/// In separate passes, by tiles and in whole frames: the same bits, and those of the twin to rounding.
#[test]
fn every_form_follows_alike() {
    let Some(device) = support::device_with(device_limits) else { return };
    let limited = |mut cloth: Cloth| {
        cloth.limits = Some((0..cloth.len()).map(|k| if k % 3 == 0 { 0.05 } else { -1.0 }).collect());
        // Duplicates have one limit.
        let (starts, members) = cloth.rings();
        let rings: Vec<Vec<u32>> = starts.windows(2).map(|r| members[r[0] as usize..r[1] as usize].to_vec()).collect();
        let mut limits = cloth.limits.as_deref().unwrap().to_vec();
        rings.iter().for_each(|ring| ring.iter().for_each(|k| limits[*k as usize] = limits[ring[0] as usize]));
        cloth.limits = Some(limits.into());
        cloth
    };
    for (cloth, whole) in [(sleeve(), true), (limited(sleeve()), true), (sheet(70), false), (limited(sheet(70)), false)]
    {
        let scene = scene(cloth);
        let run = |fused| {
            let mut rig = Rig::gpu(scene.clone(), &Options { fused, ..Options::default() }, &device);
            let plan = rig.stepper.plan();
            let holds = plan.passes.iter().filter(|p| matches!(p.form, Form::Whole(_))).count();
            let tiles = plan.passes.iter().filter(|p| matches!(p.form, Form::Tile(_))).count();
            frame(&mut rig, 1);
            let first = rig.positions(0);
            (2..4).for_each(|n| frame(&mut rig, n));
            (holds, tiles, rig.positions(0), rig.previous(0), first)
        };
        let (fused, apart) = (run(true), run(false));
        assert_eq!((fused.0 > 0, fused.1 > 0, apart.0 + apart.1), (whole, !whole, 0));
        let mut cpu = Rig::cpu(scene.clone(), &Options::default());
        // One frame: what rounding leaves doubles every few steps where a sheet buckles.
        frame(&mut cpu, 1);
        let far = largest(&cpu.positions(0), &fused.4);
        assert!(far < 1e-5, "{far}");
        let far = largest(&apart.2, &fused.2);
        if support::alike::tolerates(&device) {
            assert!(far < 1e-4, "{far}");
        } else {
            assert!(apart.2 == fused.2 && apart.3 == fused.3, "{far}");
        }
    }
}

#[test]
fn instances_share_a_dispatch_and_each_has_its_own_joints() {
    let mut scene = scene(sleeve());
    scene.cloths.extend([sleeve(), sleeve()]);
    let (cloth, rest) = (sleeve(), tube(17, 12, 1).positions().to_vec());
    for mut rig in Rig::both(&scene, &Options::default()) {
        for n in 1..6 {
            for c in 0..3 {
                rig.stepper.set_joints(c, &columns(&pose(f64::from(n * (c as u32 + 1)) * FRAME))).unwrap();
            }
            rig.frame(FRAME);
        }
        for c in 0..3 {
            let far = off(&cloth, &rest, &rig.positions(c), &pose(f64::from(5 * (c as u32 + 1)) * FRAME));
            assert!(far < 1e-6, "{} cloth {c}: {far}", rig.name());
        }
        // The others go on where they are as one leaves.
        rig.stepper.remove_cloth(0).unwrap();
        rig.stepper.set_joints(0, &columns(&pose(0.2))).unwrap();
        rig.frame(FRAME);
        assert!(off(&cloth, &rest, &rig.positions(0), &pose(0.2)) < 1e-6, "{}", rig.name());
        assert!(off(&cloth, &rest, &rig.positions(1), &pose(15.0 * FRAME)) < 1e-6, "{}", rig.name());
    }
}

#[test]
fn a_follower_that_takes_the_place_of_another_cloth_begins_on_its_own_joints() {
    let (cloth, rest) = (sleeve(), tube(17, 12, 1).positions().to_vec());
    let mut scene = scene(cloth.clone());
    scene.cloths.extend([cloth.clone(), cloth.clone()]);
    // Cloths that have the skin and do not follow it.
    let mut still = tube(17, 12, 1);
    let ends: Vec<u32> = (0..204).filter(|k| k / 17 == 0 || k / 17 == 11).collect();
    still.pin(&ends).unwrap();
    scene.cloths.extend([still.clone(), still]);
    for mut rig in Rig::both(&scene, &Options::default()) {
        for n in 1..4 {
            for c in 0..3 {
                rig.stepper.set_joints(c, &columns(&pose(f64::from(n) * 0.3))).unwrap();
            }
            rig.frame(FRAME);
        }
        // One that moves leaves, and one that does not follow.
        rig.stepper.remove_cloth(1).unwrap();
        rig.stepper.remove_cloth(3).unwrap();
        for _ in 0..2 {
            rig.stepper.add_cloth(cloth.clone()).unwrap();
        }
        rig.frame(FRAME);
        rig.frame(FRAME);
        let last = rig.stepper.scene().cloths.len();
        for c in last - 2..last {
            let far = off(&cloth, &rest, &rig.positions(c), &pose(0.0));
            assert!(far < 1e-6, "{} cloth {c}: {far}", rig.name());
        }
        assert!(off(&cloth, &rest, &rig.positions(0), &pose(0.9)) < 1e-6, "{}", rig.name());
    }
}

#[test]
fn joints_that_move_as_the_level_changes_move_over_the_whole_frame() {
    let plain = Options { substeps: Some(8), ..Options::default() };
    for mut rig in Rig::both(&scene(sheet(33)), &plain) {
        frame(&mut rig, 1);
        rig.stepper.set_level(0, 1).unwrap();
        let start = rig.positions(0);
        frame(&mut rig, 20);
        let (end, before) = (rig.positions(0), rig.previous(0));
        let moved = |k: usize| (0..3).map(|c| (end[k][c] - start[k][c]).abs()).fold(0.0, f32::max);
        assert!((0..17).any(|k| moved(k) > 0.01), "{}", rig.name());
        for (k, c) in (0..17).flat_map(|k| [(k, 0), (k, 1), (k, 2)]) {
            let (way, step) = (end[k][c] - start[k][c], end[k][c] - before[k][c]);
            assert!((step - way / 8.0).abs() < 1e-5, "{} {k}: {step} of {way}", rig.name());
        }
    }
}
