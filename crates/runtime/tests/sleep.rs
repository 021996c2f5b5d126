//! Cloth falls asleep when it is at rest, costs nothing then, and wakes when it is changed or a collider comes close.

use crate::support::rig::{FRAME, Rig};
use crate::support::{self, curtain, scene, wind};
use gimage_runtime::*;

fn sleepy() -> Options {
    // Passes of their own for each cloth, to be counted.
    Options { substeps: Some(4), sleep: Some(Sleep { speed: 0.02, after: 0.25 }), fused: false, ..Options::default() }
}

/// A damped curtain that hangs still after a while, and one that swings on.
fn two() -> Scene {
    let mut still = curtain(10);
    still.damping = 8.0;
    let mut swings = curtain(10);
    swings.place(swings.positions().iter().map(|p| [p[0], p[1] * 0.6, -p[1] * 0.8]).collect()).unwrap();
    let mut scene = scene(still);
    scene.cloths.push(swings);
    scene
}

/// Frames until the first cloth sleeps.
fn until_asleep(rig: &mut Rig) -> Option<u32> {
    (0..600).find(|_| {
        rig.frame(FRAME);
        rig.stepper.is_asleep(0)
    })
}

#[test]
fn a_still_cloth_sleeps_and_a_swinging_one_does_not() {
    for mut rig in Rig::both(&two(), &sleepy()) {
        let awake = rig.stepper.plan().dispatches();
        let frames = until_asleep(&mut rig).unwrap();
        eprintln!("{}: asleep after {frames} frames", rig.name());
        // Not before it was calm for 0.25 s.
        assert!(frames >= 14, "{}: {frames}", rig.name());
        assert!(!rig.stepper.is_asleep(1), "{}", rig.name());
        let plan = rig.stepper.plan();
        assert_eq!(plan.dispatches() * 2, awake, "{}", rig.name());
        assert!(plan.passes.iter().all(|p| p.cloth == 1), "{}", rig.name());
        let (at, other) = (rig.positions(0), rig.positions(1));
        rig.frames(30);
        assert_eq!(rig.positions(0), at, "{}", rig.name());
        assert_ne!(rig.positions(1), other, "{}", rig.name());
    }
}

#[test]
fn every_change_wakes() {
    type Change = fn(&mut Stepper);
    let changes: [(&str, Change); 9] = [
        ("colliders", |s| {
            s.set_colliders(vec![Collider::new(Shape::Sphere { radius: 0.1 }, [0.5, -0.5, 0.0])]).unwrap()
        }),
        ("wind", |s| s.set_wind(Some(wind(false))).unwrap()),
        ("gravity", |s| s.set_gravity([1.0, -9.0, 0.0]).unwrap()),
        ("a pin", |s| s.set_pinned(0, 3, false).unwrap()),
        ("a position", |s| s.set_position(0, 3, [0.3, 0.1, 0.0]).unwrap()),
        ("a cut", |s| s.cut([0.5, -0.4, 3.0], [-4.0, -0.4, -2.0], [5.0, -0.4, -2.0]).unwrap()),
        ("a transform", |s| {
            let shift = [[1.0, 0.0, 0.0, 0.0], [0.0, 1.0, 0.0, 0.0], [0.0, 0.0, 1.0, 0.0], [0.0, 0.1, 0.0, 1.0]];
            s.transform(0, &[0, 1, 2], shift).unwrap();
        }),
        ("a drag", |s| {
            let corners = [[0.5, -0.5, 0.0], [0.5, -0.6, 0.0], [0.6, -0.6, 0.0]];
            let (texel, barycentric) = ([5, 5], [1.0, 0.0, 0.0]);
            let particles = [55, 65, 66];
            let hit = Hit {
                cloth: 0,
                handle: None,
                grid: 0,
                texel,
                triangle: 0,
                particles,
                barycentric,
                corners,
                distance: 1.0,
            };
            let drag = s.grab(&hit).unwrap();
            s.drag(&drag, [0.5, -0.3, 0.2]).unwrap();
        }),
        ("a call", |s| s.set_asleep(0, false).unwrap()),
    ];
    for (name, change) in changes {
        for mut rig in Rig::both(&Scene { cloths: two().cloths[..1].to_vec(), ..two() }, &sleepy()) {
            until_asleep(&mut rig).unwrap();
            assert_eq!(rig.stepper.plan().dispatches(), 0, "{}", rig.name());
            let at = rig.positions(0);
            change(&mut rig.stepper);
            assert!(!rig.stepper.is_asleep(0), "{} {name}", rig.name());
            rig.frame(FRAME);
            assert_ne!(rig.positions(0), at, "{} {name}", rig.name());
        }
    }
}

#[test]
fn in_wind_cloth_stays_awake_and_is_not_watched() {
    let windy = Scene { wind: Some(Wind { velocity: [0.0; 3], ..wind(false) }), ..two() };
    for mut rig in Rig::both(&windy, &sleepy()) {
        assert!(rig.stepper.plan().passes.iter().all(|p| p.shader != "speed"));
        assert_eq!(until_asleep(&mut rig), None, "{}", rig.name());
    }
}

#[test]
fn without_the_option_nothing_is_spent_and_nothing_sleeps() {
    let still = Scene { cloths: two().cloths[..1].to_vec(), ..two() };
    let plan = |options: &Options| Rig::cpu(still.clone(), options).stepper.plan();
    let (watched, not) = (plan(&sleepy()), plan(&Options { sleep: None, ..sleepy() }));
    // Two dispatches per frame, two numbers of 64 particles each and their largest.
    assert_eq!((watched.dispatches(), watched.bytes()), (not.dispatches() + 2, not.bytes() + 8 + 4));
    let mut rig = Rig::cpu(still, &Options { sleep: None, ..sleepy() });
    assert_eq!(until_asleep(&mut rig), None);
}

#[test]
fn the_option_can_be_turned_on_and_off() {
    let still = Scene { cloths: two().cloths[..1].to_vec(), ..two() };
    for mut rig in Rig::both(&still, &Options { sleep: None, ..sleepy() }) {
        rig.frames(200);
        rig.stepper.set_options(sleepy()).unwrap();
        assert!(until_asleep(&mut rig).is_some(), "{}", rig.name());
        rig.stepper.set_options(Options { sleep: None, ..sleepy() }).unwrap();
        rig.stepper.set_asleep(0, false).unwrap();
        assert_eq!(until_asleep(&mut rig), None, "{}", rig.name());
    }
    let wrong = |speed, after| Options { sleep: Some(Sleep { speed, after }), ..Options::default() };
    assert!(Stepper::new(two(), wrong(0.0, 1.0), None).is_err());
    assert!(Stepper::new(two(), wrong(0.1, -1.0), None).is_err());
}

#[test]
fn a_frame_before_the_host_submits_is_not_lost() {
    // Several frames in one encoder, and no call of settle: nothing sleeps, nothing is mapped too early.
    let Some((device, queue)) = support::device() else { return };
    let still = Scene { cloths: two().cloths[..1].to_vec(), ..two() };
    let mut stepper = Stepper::new(still, sleepy(), Some((&device, &queue))).unwrap();
    for _ in 0..40 {
        let mut encoder = device.create_command_encoder(&Default::default());
        (0..6).for_each(|_| assert!(stepper.record(&mut encoder, FRAME).unwrap().steps > 0));
        queue.submit([encoder.finish()]);
    }
    assert!(!stepper.is_asleep(0));
    // Measurements of the first frames come in order, then those since.
    for _ in 0..40 {
        stepper.settle().unwrap();
        let mut encoder = device.create_command_encoder(&Default::default());
        stepper.record(&mut encoder, FRAME).unwrap();
        queue.submit([encoder.finish()]);
        device.poll(wgpu::PollType::wait_indefinitely()).unwrap();
    }
    assert!(stepper.is_asleep(0));
}

/// The first curtain of [`two`] with a ball far from it, and one for the hand of a host.
fn still_among_balls() -> Scene {
    let ball = |at| Collider::new(Shape::Sphere { radius: 0.1 }, at);
    Scene { cloths: two().cloths[..1].to_vec(), colliders: vec![ball([3.0, 0.0, 0.0]), ball([0.0, 4.0, 0.0])], ..two() }
}

/// Somewhere on a circle of 1 m around the second ball's start, whose lowest point is 2 m above the curtain.
fn circling(frame: u32) -> scene::Pose {
    let (sin, cos) = (0.1 * frame as f32).sin_cos();
    scene::Pose { position: [cos, 4.0 + sin, 0.0], ..scene::Pose::default() }
}

#[test]
fn cloth_falls_asleep_among_colliders_that_move_elsewhere_and_sleeps_on() {
    for mut rig in Rig::both(&still_among_balls(), &sleepy()) {
        let asleep = (0..600).find(|frame| {
            rig.stepper.move_collider(1, &circling(*frame)).unwrap();
            rig.frame(FRAME);
            rig.stepper.is_asleep(0)
        });
        let from = asleep.unwrap_or_else(|| panic!("{}: it stays awake", rig.name()));
        let at = rig.positions(0);
        for frame in from..from + 60 {
            rig.stepper.move_collider(1, &circling(frame)).unwrap();
            rig.frame(FRAME);
            assert!(rig.stepper.is_asleep(0), "{}: frame {frame}", rig.name());
        }
        // The same by a list of all colliders, with one more, and without any.
        let mut list = rig.stepper.scene().colliders.clone();
        for frame in 0..30 {
            list[1].center = circling(frame).position;
            rig.stepper.set_colliders(list.clone()).unwrap();
            rig.frame(FRAME);
        }
        list.push(Collider::new(Shape::Box { half: [0.5; 3] }, [0.0, -9.0, 0.0]));
        rig.stepper.set_colliders(list).unwrap();
        rig.frame(FRAME);
        rig.stepper.set_colliders(vec![]).unwrap();
        rig.frame(FRAME);
        assert!(rig.stepper.is_asleep(0) && rig.positions(0) == at, "{}", rig.name());
    }
}

#[test]
fn colliders_that_come_close_wake_and_so_does_one_that_passes_within_a_frame() {
    let ends: [[f32; 3]; 2] = [[0.5, -0.5, 0.05], [0.5, -4.0, 0.0]];
    for to in ends {
        for mut rig in Rig::both(&still_among_balls(), &sleepy()) {
            until_asleep(&mut rig).unwrap();
            let above = scene::Pose { position: [0.5, 4.0, 0.0], ..scene::Pose::default() };
            rig.stepper.move_collider(1, &above).unwrap();
            rig.frame(FRAME);
            assert!(rig.stepper.is_asleep(0), "{} {to:?}", rig.name());
            let at = rig.positions(0);
            rig.stepper.move_collider(1, &scene::Pose { position: to, ..above }).unwrap();
            rig.frame(FRAME);
            assert!(!rig.stepper.is_asleep(0), "{} {to:?}", rig.name());
            assert_ne!(rig.positions(0), at, "{} {to:?}", rig.name());
        }
    }
}

#[test]
fn cloth_wakes_where_its_support_leaves_it() {
    let mut cloth = Flat::square("towel", 9).cloth().unwrap();
    cloth.place(cloth.positions().iter().map(|p| [p[0], 0.001, p[2]]).collect()).unwrap();
    (cloth.damping, cloth.thickness) = (8.0, Some(0.004));
    let mut scene = scene(cloth);
    scene.colliders =
        vec![Collider { friction: 1.0, ..Collider::new(Shape::Box { half: [2.0, 0.5, 2.0] }, [0.0, -0.5, 0.0]) }];
    for mut rig in Rig::both(&scene, &sleepy()) {
        until_asleep(&mut rig).unwrap_or_else(|| panic!("{}", rig.name()));
        let lowest = |rig: &Rig| rig.positions(0).iter().map(|p| p[1]).fold(f32::INFINITY, f32::min);
        let before = lowest(&rig);
        rig.stepper.move_collider(0, &scene::Pose { position: [0.0, -2.5, 0.0], ..scene::Pose::default() }).unwrap();
        rig.frames(30);
        assert!(lowest(&rig) < before - 0.3, "{}: {before} {}", rig.name(), lowest(&rig));
    }
}

#[test]
fn a_collider_that_is_teleported_and_then_moved_sweeps_from_where_it_was_put() {
    for mut rig in Rig::both(&still_among_balls(), &sleepy()) {
        until_asleep(&mut rig).unwrap();
        let at = |y| scene::Pose { position: [0.5, y, 0.0], ..scene::Pose::default() };
        rig.stepper.teleport_collider(1, &at(4.0)).unwrap();
        rig.frame(FRAME);
        assert!(rig.stepper.is_asleep(0), "{}", rig.name());
        // It ends where it was, and on its way it goes through the curtain.
        rig.stepper.teleport_collider(1, &at(-5.0)).unwrap();
        rig.stepper.move_collider(1, &at(4.0)).unwrap();
        rig.frame(FRAME);
        assert!(!rig.stepper.is_asleep(0), "{}", rig.name());
    }
}

#[test]
fn restored_cloth_sleeps_on_among_colliders_that_move_elsewhere() {
    for mut rig in Rig::both(&still_among_balls(), &sleepy()) {
        until_asleep(&mut rig).unwrap();
        let snapshot = rig.stepper.snapshot().unwrap();
        for near in [false, true] {
            rig.stepper.set_asleep(0, false).unwrap();
            rig.stepper.restore(&snapshot).unwrap();
            assert!(rig.stepper.is_asleep(0), "{}", rig.name());
            let to = if near { scene::Pose { position: [0.5, -0.5, 0.0], ..circling(0) } } else { circling(3) };
            rig.stepper.move_collider(1, &to).unwrap();
            rig.frame(FRAME);
            assert_eq!(rig.stepper.is_asleep(0), !near, "{}", rig.name());
        }
    }
}

#[test]
fn cloth_that_is_put_to_sleep_sleeps_while_another_is_moved_by_its_pins() {
    let mut scene = still_among_balls();
    scene.cloths.push(curtain(8));
    let mut rig = Rig::cpu(scene, &sleepy());
    rig.stepper.set_asleep(0, true).unwrap();
    for frame in 0..5 {
        rig.stepper.set_position(1, 0, [0.0, 0.01 * frame as f32, 0.0]).unwrap();
        rig.stepper.move_collider(1, &circling(frame)).unwrap();
        rig.frame(FRAME);
        assert!(rig.stepper.is_asleep(0), "{frame}");
    }
}
