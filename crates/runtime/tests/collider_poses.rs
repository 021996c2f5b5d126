//! Colliders that the host moves by poses, and the groups that decide which cloth meets which collider.

use crate::support::rig::{FRAME, Rig, largest};
use crate::support::{curtain, device_with, on_colliders, scene};
use gimage_runtime::scene::{Pose, about};
use gimage_runtime::*;

fn options() -> Options {
    Options { substeps: Some(4), tethers: 0, threads: 1, ..Options::default() }
}

/// Where colliders are in a frame: they move, turn and rest.
fn pose(start: &Collider, frame: u32, k: usize) -> Pose {
    let on = f64::from(frame.min(5)) * (0.02 + 0.01 * k as f64);
    let [x, y, z] = start.center;
    let rotation = if k == 3 { start.rotation } else { about([0.1, 1.0, k as f32], 3.0 * on) };
    Pose { position: [x + 0.2 * on as f32, y + 0.1 * on as f32, z], rotation }
}

#[test]
fn poses_are_velocities_by_bits() {
    let mut start = on_colliders(9);
    for (k, collider) in start.colliders.iter_mut().enumerate() {
        *collider = collider.moved(&Pose::default(), &pose(collider, 0, k), 0.0);
    }
    let by_hand = Rig::both(&start, &options());
    for (mut a, mut b) in by_hand.into_iter().zip(Rig::both(&start, &options())) {
        for frame in 0..8 {
            let moved = |(k, c): (usize, &Collider)| {
                c.moved(&pose(&start.colliders[k], frame, k), &pose(&start.colliders[k], frame + 1, k), FRAME)
            };
            let colliders = a.stepper.scene().colliders.iter().enumerate().map(moved).collect();
            a.stepper.set_colliders(colliders).unwrap();
            // A collider that is not moved rests.
            for k in (0..start.colliders.len()).filter(|_| frame < 5) {
                // The last pose counts.
                b.stepper.move_collider(k, &Pose { position: [9.0; 3], ..Pose::default() }).unwrap();
                b.stepper.move_collider(k, &pose(&start.colliders[k], frame + 1, k)).unwrap();
            }
            [&mut a, &mut b].into_iter().for_each(|rig| rig.frame(FRAME));
            assert_eq!(a.stepper.scene().colliders, b.stepper.scene().colliders, "{} frame {frame}", a.name());
        }
        assert!(a.positions(0) == b.positions(0) && a.previous(0) == b.previous(0), "{}", a.name());
        assert!(b.stepper.scene().colliders.iter().all(|c| (c.velocity, c.spin) == ([0.0; 3], [0.0; 3])));
    }
}

#[test]
fn velocities_are_over_the_time_since_the_last_step() {
    let mut all = scene(curtain(5));
    all.colliders = vec![Collider::new(Shape::Sphere { radius: 0.1 }, [0.0, -3.0, 0.0]); 2];
    let mut stepper = Stepper::on_cpu(all, Options { substeps: Some(1), tethers: 2, ..options() }).unwrap();
    let at = |x: f32| Pose { position: [x, -3.0, 0.0], ..Pose::default() };
    let velocity = |stepper: &Stepper, k: usize| stepper.scene().colliders[k].velocity[0];
    // Two frames without a step: what one of them brings counts with the time of both.
    stepper.move_collider(0, &at(0.1)).unwrap();
    assert_eq!(stepper.advance(0.4 * FRAME).unwrap().steps, 0);
    stepper.teleport_collider(1, &at(5.0)).unwrap();
    assert_eq!(velocity(&stepper, 1), 0.0);
    assert_eq!(stepper.advance(0.4 * FRAME).unwrap().steps, 0);
    stepper.move_collider(1, &at(5.1)).unwrap();
    assert_eq!(stepper.advance(0.4 * FRAME).unwrap().steps, 1);
    let speeds = [0, 1].map(|k| f64::from(velocity(&stepper, k)) * 0.4 * FRAME);
    assert!((speeds[0] - 0.1 / 3.0).abs() < 1e-6 && (speeds[1] - 0.1 / 2.0).abs() < 1e-6, "{speeds:?}");
    assert_eq!(stepper.scene().colliders[1].center, [5.1, -3.0, 0.0]);
    // The shorter way round, also by the quaternion of the opposite sign; and without time there is none.
    let turn = about([0.0, 1.0, 0.0], 0.1).map(|x| -x);
    stepper.move_collider(0, &Pose { rotation: turn, ..at(0.1) }).unwrap();
    stepper.advance(0.8 * FRAME).unwrap();
    let spin = stepper.scene().colliders[0].spin[1];
    assert!((f64::from(spin) * 0.8 * FRAME - 0.1).abs() < 1e-6 && velocity(&stepper, 0) == 0.0, "{spin}");
    stepper.move_collider(0, &at(7.0)).unwrap();
    stepper.advance(0.0).unwrap();
    assert_eq!((velocity(&stepper, 0), stepper.scene().colliders[0].center[0]), (0.0, 7.0));
    for wrong in [Pose { rotation: [0.0; 4], ..at(0.0) }, at(f32::NAN)] {
        assert!(stepper.move_collider(0, &wrong).is_err() && stepper.teleport_collider(0, &wrong).is_err());
    }
    let error = stepper.move_collider(2, &at(0.0)).unwrap_err().to_string();
    assert_eq!(error, "there is no collider 2; there are 2");
    // Replaced colliders know nothing of a move before.
    stepper.move_collider(1, &at(0.0)).unwrap();
    stepper.set_colliders(vec![stepper.scene().colliders[0]]).unwrap();
    stepper.advance(FRAME).unwrap();
    assert_eq!((velocity(&stepper, 0), stepper.scene().colliders.len()), (0.0, 1));
}

#[test]
fn a_swept_body_pushes_and_a_teleported_one_does_not() {
    let mut still = curtain(9);
    still.damping = 1.0;
    let mut all = scene(still);
    let plate = Shape::Box { half: [0.4, 0.4, 0.02] };
    all.colliders = vec![Collider::new(plate, [0.5, -0.5, -0.2])];
    let through = Pose { position: [0.5, -0.5, 0.2], ..Pose::default() };
    for (mut swept, mut put) in Rig::both(&all, &options()).into_iter().zip(Rig::both(&all, &options())) {
        swept.stepper.move_collider(0, &through).unwrap();
        put.stepper.teleport_collider(0, &through).unwrap();
        [&mut swept, &mut put].into_iter().for_each(|rig| rig.frame(FRAME));
        let [a, b] = [&swept, &put].map(|rig| rig.positions(0)[40][2]);
        assert!(a > 0.2 && b.abs() < 0.01, "{}: {a} {b}", swept.name());
    }
}

/// Squares that fall onto a ball in group 0 above a floor in group 1; each cloth has its own mask.
fn grouped(n: u32, masks: &[u32]) -> Scene {
    let mut all = Scene::new("groups");
    for mask in masks {
        let mut cloth = Flat { origin: [-0.5, 0.32, -0.5], ..Flat::square("square", n) }.cloth().unwrap();
        (cloth.collision_groups, cloth.velocity) = (*mask, [0.0, -3.0, 0.0]);
        all.cloths.push(cloth);
    }
    let ball = Collider::new(Shape::Sphere { radius: 0.3 }, [0.0; 3]);
    let floor = Collider::new(Shape::HalfSpace, [0.0, -0.5, 0.0]);
    all.colliders =
        vec![Collider { collision_groups: 1, friction: 0.5, ..ball }, Collider { collision_groups: 2, ..floor }];
    all
}

#[test]
fn cloth_meets_the_colliders_of_its_groups_alone() {
    let masks = [u32::MAX, 2, 0, 1, 7, 2];
    let roomy = device_with(device_limits);
    for (fused, solver) in [(true, Solver::Xpbd), (false, Solver::Classic)] {
        let (all, options) = (grouped(9, &masks), Options { fused, solver, ..options() });
        let mut rigs = vec![Rig::cpu(all.clone(), &options)];
        rigs.extend(roomy.iter().map(|device| Rig::gpu(all.clone(), &options, device)));
        for rig in &mut rigs {
            let name = format!("{solver:?} {}", rig.name());
            rig.frames(15);
            let found = [0, 1, 2, 3, 4, 5].map(|cloth| rig.positions(cloth)[40][1]);
            assert!([0, 3, 4].iter().all(|c| found[*c] > 0.28), "{name}: {found:?}");
            assert!([1, 5].iter().all(|c| (found[*c] + 0.5).abs() < 0.02), "{name}: {found:?}");
            assert!(found[2] < -0.6 && found[1] == found[5] && found[0] == found[4], "{name}: {found:?}");
            // By bits what a scene of these colliders alone gives.
            for cloth in [0, 1, 3] {
                let mut alone = grouped(9, &[u32::MAX]);
                alone.colliders.retain(|c| c.collision_groups & masks[cloth] != 0);
                let device = roomy.as_ref().filter(|_| rig.name() == "gpu");
                let mut other = match device {
                    Some(device) => Rig::gpu(alone, &Options { fused: false, ..options.clone() }, device),
                    None => Rig::cpu(alone, &options),
                };
                other.frames(15);
                assert!(rig.positions(cloth) == other.positions(0), "{name}: cloth {cloth}");
            }
        }
    }
    // A few steps, before rounding grows.
    let Some(device) = roomy else { return };
    let (once, mut start) = (Options { substeps: Some(1), step: FRAME / 4.0, ..options() }, grouped(9, &masks));
    start.cloths.iter_mut().for_each(|cloth| cloth.velocity = [0.5, -6.0, 0.0]);
    let (mut cpu, mut gpu) = (Rig::cpu(start.clone(), &once), Rig::gpu(start, &once, &device));
    [&mut cpu, &mut gpu].into_iter().for_each(|rig| (0..2).for_each(|_| rig.frame(FRAME / 4.0)));
    let apart = (0..6).map(|c| largest(&cpu.positions(c), &gpu.positions(c))).fold(0.0, f32::max);
    assert!(apart < 3e-6 && cpu.positions(0) != cpu.positions(2), "{apart} m");
}

#[test]
fn cloths_that_come_and_go_meet_moving_colliders_in_their_own_way() {
    let to = |frame: u32| Pose { position: [0.01, 0.005, 0.0].map(|x| x * frame as f32), ..Pose::default() };
    let run = |rig: &mut Rig, frames: std::ops::Range<u32>| {
        for frame in frames {
            rig.stepper.move_collider(0, &to(frame)).unwrap();
            rig.frame(FRAME);
        }
    };
    let masks = [2, 3, 1, 0];
    for mut rig in Rig::both(&grouped(9, &[1, 2]), &options()) {
        run(&mut rig, 1..4);
        let late = masks.map(|mask| rig.stepper.add_cloth(grouped(9, &[mask]).cloths.remove(0)).unwrap());
        run(&mut rig, 4..8);
        // Takes its kind of contact along; cloth of the same groups is there still.
        rig.stepper.remove_cloth(0).unwrap();
        run(&mut rig, 8..16);
        for (cloth, mask) in late.into_iter().zip(masks) {
            let mut alone = grouped(9, &[mask]);
            alone.colliders[0].center = to(3).position;
            let mut fresh = rig.another(&alone);
            run(&mut fresh, 4..16);
            let index = rig.stepper.index(cloth).unwrap();
            assert!(rig.positions(index) == fresh.positions(0), "{} {mask}", rig.name());
            rig.stepper.set_asleep(cloth, true).unwrap();
        }
        let heights = late.map(|cloth| rig.positions(rig.stepper.index(cloth).unwrap())[40][1]);
        assert!(heights[1] > 0.28 && heights[2] > 0.28 && heights[0] < 0.0, "{heights:?}");
        // The ball wakes those that meet it, and groups are those of one cloth.
        run(&mut rig, 16..17);
        assert_eq!(late.map(|cloth| rig.stepper.is_asleep(cloth)), [true, false, false, true], "{}", rig.name());
        rig.stepper.set_collision_groups(late[2], 2).unwrap();
        let of = |cloth| rig.stepper.scene().cloths[rig.stepper.index(cloth).unwrap()].collision_groups;
        assert_eq!(late.map(of), [2, 3, 2, 0]);
        let gone = rig.stepper.remove_cloth(late[3]).map(|_| late[3]).unwrap();
        assert!(matches!(rig.stepper.set_collision_groups(gone, 1), Err(Error::NoCloth(_))));
    }
}

#[test]
fn groups_cost_only_cloth_that_meets_a_collider() {
    let contact = |stepper: &Stepper, cloth: usize| {
        let passes = stepper.plan().passes;
        passes.iter().any(|p| p.cloth == cloth && matches!(p.form.pass(), Some(Pass::Contact(_))))
    };
    let options = Options { fused: false, sleep: Some(Sleep { speed: 1e-3, after: 10.0 }), ..options() };
    let mut stepper = Stepper::on_cpu(grouped(5, &[2, 4]), options).unwrap();
    assert_eq!([0, 1].map(|c| contact(&stepper, c)), [true, false]);
    // A body of another group wakes no cloth, and neither does one that stays below it.
    let asleep = |stepper: &mut Stepper, k: usize, height: f32| {
        [0, 1].into_iter().for_each(|c| stepper.set_asleep(c, true).unwrap());
        let to = Pose { position: [0.1, height, 0.0], ..Pose::default() };
        stepper.move_collider(k, &to).unwrap();
        stepper.advance(FRAME).unwrap();
        [0, 1].map(|c| stepper.is_asleep(c))
    };
    assert_eq!(asleep(&mut stepper, 0, 0.4), [true, true]);
    assert_eq!(asleep(&mut stepper, 1, 0.0), [true, true]);
    assert_eq!(asleep(&mut stepper, 1, 0.4), [false, true]);
    stepper.set_asleep(0, true).unwrap();
    stepper.set_collision_groups(1, 1).unwrap();
    assert_eq!([0, 1].map(|c| stepper.is_asleep(c)), [true, false]);
    stepper.set_asleep(0, false).unwrap();
    assert_eq!([0, 1].map(|c| contact(&stepper, c)), [true, true]);
    assert!(stepper.set_collision_groups(2, 1).is_err());
    // Substeps are chosen for the colliders that are met.
    let of = |mask| Stepper::on_cpu(grouped(96, &[mask]), Options::default()).unwrap().substeps();
    let mut free = grouped(96, &[1]);
    free.colliders.clear();
    assert_eq!(of(4), Stepper::on_cpu(free, Options::default()).unwrap().substeps());
    assert!(of(1) > of(4), "{} {}", of(1), of(4));
}

#[test]
fn masks_that_all_meet_change_no_bit_and_no_dispatch() {
    let with = |masks: [u32; 2]| {
        let mut all = grouped(9, &masks);
        all.colliders.iter_mut().for_each(|c| c.collision_groups = 1 << 31 | 5);
        all
    };
    let rigs = Rig::both(&with([u32::MAX; 2]), &options()).into_iter();
    for (mut a, mut b) in rigs.zip(Rig::both(&with([1, 1]), &options())) {
        assert!(a.stepper.plan() == b.stepper.plan(), "{}", a.name());
        [&mut a, &mut b].into_iter().for_each(|rig| rig.frames(6));
        assert!(a.positions(1) == b.positions(1), "{}", a.name());
    }
}
