//! Cloth that is simulated in a moving frame of reference: its motion in the world, on all backends and in all forms.

use crate::support::rig::{FRAME, Rig, largest};
use crate::support::{self, hung_tube, scene, wind};
use gimage_runtime::scene::about;
use gimage_runtime::*;

/// A frame that runs along a bend, turns and tumbles, `far` from the origin.
fn tumbling(time: f64, far: f64) -> MovingFrame {
    let position = [far + (3.0 * time).sin(), 0.5 * time * time, (2.0 * time).cos()];
    let rotation = about([0.3, 1.0, -0.2], 4.0 * time + (5.0 * time).sin()).map(f64::from);
    MovingFrame { position, rotation }
}

fn sheet(name: &str) -> Cloth {
    Flat { down: [0.0, -0.4, 0.0], ..Flat::square(name, 12) }.cloth().unwrap()
}

fn hung() -> Cloth {
    let mut cloth = sheet("hung");
    cloth.pin(&[0, 11]).unwrap();
    cloth
}

/// Particles without springs.
fn unbound() -> Cloth {
    let of = sheet("unbound");
    let (name, grids, positions) = ("unbound".into(), of.grids().to_vec(), of.positions().to_vec());
    let particles = of.particles().to_vec();
    Cloth::new(Parts { name, grids, positions, particles, rest: Rest::None, mass: Mass::Constant(1e-3) }).unwrap()
}

fn options() -> Options {
    Options { substeps: Some(8), ..Options::default() }
}

/// Positions in the world.
fn world(stepper: &Stepper, frame: &MovingFrame) -> Vec<[f64; 3]> {
    let positions = stepper.positions(0).unwrap();
    positions.iter().map(|[x, y, z, _]| frame.to_world([*x, *y, *z].map(f64::from))).collect()
}

fn farthest(a: &[[f64; 3]], b: &[[f64; 3]]) -> f64 {
    let apart = |(p, q): (&[f64; 3], &[f64; 3])| (0..3).map(|c| (p[c] - q[c]).powi(2)).sum::<f64>().sqrt();
    a.iter().zip(b).map(apart).fold(0.0, f64::max)
}

/// Moves the frame for a number of frames of the host.
fn run(stepper: &mut Stepper, frames: std::ops::RangeInclusive<u32>, far: f64) {
    for frame in frames {
        stepper.set_moving_frame(0, &tumbling(f64::from(frame) * FRAME, far)).unwrap();
        stepper.advance(FRAME).unwrap();
    }
}

#[test]
fn free_particles_stand_still_in_the_world_however_the_frame_moves() {
    let mut scene = scene(unbound());
    scene.gravity = [0.0; 3];
    let mut stepper = Stepper::on_cpu(scene, options()).unwrap();
    run(&mut stepper, 0..=0, 0.0);
    let start = world(&stepper, &tumbling(0.0, 0.0));
    for frame in 1..=120 {
        run(&mut stepper, frame..=frame, 0.0);
        let far = farthest(&world(&stepper, &tumbling(f64::from(frame) * FRAME, 0.0)), &start);
        // Velocities are rounded to 6e-5 m/s where particles are.
        assert!(far < 1e-3, "frame {frame}: {far} m");
    }
}

#[test]
fn particles_fall_as_in_the_world() {
    let mut stepper = Stepper::on_cpu(scene(unbound()), options()).unwrap();
    run(&mut stepper, 0..=60, 0.0);
    let mut plain = Stepper::on_cpu(scene(unbound()), options()).unwrap();
    // The start, in the place that the frame had.
    (0..=60).for_each(|_| _ = plain.advance(FRAME).unwrap());
    let start = tumbling(0.0, 0.0);
    let fallen = plain.positions(0).unwrap()[0][1];
    let at: Vec<_> = world(&stepper, &tumbling(60.0 * FRAME, 0.0));
    let expected: Vec<_> = unbound()
        .positions()
        .iter()
        .map(|p| start.to_world(p.map(f64::from)))
        .map(|[x, y, z]| [x, y + f64::from(fallen), z])
        .collect();
    // It falls 5 m. Gravity turns by up to 0.15 rad in a frame, in which it has one direction.
    let far = farthest(&at, &expected);
    assert!(fallen < -4.5 && far < 0.02, "{far} m");
}

/// The columns of the matrix of a frame.
fn matrix(frame: &MovingFrame) -> [f32; 16] {
    let o = frame.to_world([0.0; 3]);
    let axis = |c: usize| {
        let end = frame.to_world([0, 1, 2].map(|k| if k == c { 1.0 } else { 0.0 }));
        [0, 1, 2].map(|k| (end[k] - o[k]) as f32)
    };
    let [[a, b, c], [d, e, f], [g, h, i]] = [0, 1, 2].map(axis);
    let [x, y, z] = o.map(|x| x as f32);
    [a, b, c, 0.0, d, e, f, 0.0, g, h, i, 0.0, x, y, z, 1.0]
}

/// The largest difference in the world, and how far the cloth was moved out of its rest, between pins that joints carry and pins
/// that stand in the frame.
fn carried(frames: u32, at: impl Fn(f64) -> MovingFrame) -> [f64; 2] {
    let mut local = Stepper::on_cpu(scene(hung()), options()).unwrap();
    local.set_moving_frame(0, &at(0.0)).unwrap();
    let mut carried = hung();
    let influence = Influence { joints: [0; 4], weights: [1.0, 0.0, 0.0, 0.0] };
    carried.set_skin(vec![SkinJoint { name: "root".into(), ..SkinJoint::default() }], &[influence; 144]).unwrap();
    carried.follow_joints(&[matrix(&at(0.0))]).unwrap();
    let mut plain = Stepper::on_cpu(scene(carried), options()).unwrap();
    let (mut far, mut way) = (0.0f64, 0.0f64);
    for n in 1..=frames {
        let to = at(f64::from(n) * FRAME);
        local.set_moving_frame(0, &to).unwrap();
        local.advance(FRAME).unwrap();
        plain.set_joints(0, &[matrix(&to)]).unwrap();
        plain.advance(FRAME).unwrap();
        let stood: Vec<_> = hung().positions().iter().map(|p| to.to_world(p.map(f64::from))).collect();
        let plain = world(&plain, &MovingFrame::default());
        way = way.max(farthest(&plain, &stood));
        far = far.max(farthest(&world(&local, &to), &plain));
    }
    [far, way]
}

#[test]
fn hung_cloth_swings_as_with_pins_that_move_in_the_world() {
    let slides = |time: f64| [1.0 - (4.0 * time).cos(), 0.2 * (6.0 * time).sin(), (3.0 * time).sin()];
    let [far, way] = carried(60, |time| MovingFrame { position: slides(time), ..MovingFrame::default() });
    assert!(way > 0.3 && far < 1e-3, "sliding: {far} m of {way} m");
    // Joints go along a chord, and particles of a frame that turns too, each on its own side of the arc.
    let [far, way] = carried(20, |time| {
        let rotation = about([0.0, 1.0, 0.0], 1.0 - (3.0 * time).cos()).map(f64::from);
        MovingFrame { position: slides(time), rotation }
    });
    assert!(way > 0.2 && far < 0.05 * way, "turning: {far} m of {way} m");
}

#[test]
fn a_cloth_feels_nothing_at_shares_of_0_and_of_a_steady_course() {
    let start = run_plain(60);
    let mut cloth = hung();
    cloth.inertia = Inertia { linear: 0.0, angular: 0.0, centrifugal: 0.0 };
    let mut still = Stepper::on_cpu(scene(cloth), options()).unwrap();
    let mut steady = Stepper::on_cpu(scene(hung()), options()).unwrap();
    let at = |n: u32, wild: f64| {
        let time = f64::from(n) * FRAME;
        let sway = wild * (9.0 * time).sin();
        MovingFrame { position: [8.0 * time + sway, 2.0 * time, -sway], ..MovingFrame::default() }
    };
    let course = |n| FrameMotion { velocity: [8.0, 2.0, 0.0], seconds: FRAME, ..FrameMotion::still(at(n, 0.0)) };
    still.set_moving_frame(0, &at(0, 1.0)).unwrap();
    steady.put_moving_frame(0, &course(0)).unwrap();
    for n in 1..=60 {
        still.set_moving_frame(0, &at(n, 1.0)).unwrap();
        steady.set_moving_frame(0, &at(n, 0.0)).unwrap();
        still.advance(FRAME).unwrap();
        steady.advance(FRAME).unwrap();
    }
    for stepper in [still, steady] {
        assert_eq!(stepper.positions(0).unwrap(), start);
    }
}

fn run_plain(frames: u32) -> Vec<[f32; 4]> {
    let mut stepper = Stepper::on_cpu(scene(hung()), options()).unwrap();
    (0..frames).for_each(|_| _ = stepper.advance(FRAME).unwrap());
    stepper.positions(0).unwrap().to_vec()
}

#[test]
fn a_cloth_far_from_the_origin_moves_as_one_near_it() {
    let [near, far] = [0.0, 1e6].map(|far| {
        let mut stepper = Stepper::on_cpu(scene(hung()), options()).unwrap();
        run(&mut stepper, 0..=20, far);
        stepper.positions(0).unwrap().to_vec()
    });
    // Of the frame's velocity 1e-8 m/s is rounding there. Cloth in folds makes more of it after a second.
    assert!(largest(&near, &far) < 1e-5, "{}", largest(&near, &far));
    assert!(largest(&near, &run_plain(21)) > 0.1, "it is shaken");
}

#[test]
fn gravity_turns_into_the_frame() {
    let mut cloth = hung();
    (cloth.velocity, cloth.damping) = ([0.0, 0.0, 1.0], 1.0);
    let mut stepper = Stepper::on_cpu(scene(cloth), options()).unwrap();
    let rotation = about([0.0, 0.0, 1.0], std::f64::consts::PI).map(f64::from);
    stepper.set_moving_frame(0, &MovingFrame { position: [0.0; 3], rotation }).unwrap();
    (0..120).for_each(|_| _ = stepper.advance(FRAME).unwrap());
    let lowest = stepper.positions(0).unwrap().iter().map(|p| p[1]).fold(f32::MAX, f32::min);
    assert!(lowest > -0.01, "it hangs towards +y of the frame: {lowest}");
}

#[test]
fn a_teleport_is_not_felt_and_a_saved_motion_goes_on() {
    let mut going = Stepper::on_cpu(scene(hung()), options()).unwrap();
    run(&mut going, 0..=30, 0.0);
    let saved = (going.snapshot().unwrap(), going.moving_frame(0).unwrap().unwrap());
    run(&mut going, 31..=60, 0.0);
    let end = going.positions(0).unwrap().to_vec();
    // Back in time, in the same stepper.
    going.restore(&saved.0).unwrap();
    going.put_moving_frame(0, &saved.1).unwrap();
    run(&mut going, 31..=60, 0.0);
    assert_eq!(going.positions(0).unwrap(), end);
    // Elsewhere, without any motion but a turn of the whole world about the vertical.
    going.restore(&saved.0).unwrap();
    going.put_moving_frame(0, &saved.1).unwrap();
    let by = about([0.0, 1.0, 0.0], 2.0).map(f64::from);
    let there = MovingFrame { position: [1e4, 5.0, -3.0], rotation: by };
    let put =
        |at: &MovingFrame| MovingFrame { position: there.to_world(at.position), rotation: turned(by, at.rotation) };
    going.teleport_moving_frame(0, &put(&saved.1.frame)).unwrap();
    for frame in 31..=60 {
        going.set_moving_frame(0, &put(&tumbling(f64::from(frame) * FRAME, 0.0))).unwrap();
        going.advance(FRAME).unwrap();
    }
    let apart = largest(going.positions(0).unwrap(), &end);
    assert!(apart < 1e-4, "{apart}");
}

/// The turn that does what `b` does, then `a`.
fn turned(a: [f64; 4], b: [f64; 4]) -> [f64; 4] {
    let part = |c: usize| {
        let (d, e) = ((c + 1) % 3, (c + 2) % 3);
        a[3] * b[c] + b[3] * a[c] + a[d] * b[e] - a[e] * b[d]
    };
    [part(0), part(1), part(2), a[3] * b[3] - a[0] * b[0] - a[1] * b[1] - a[2] * b[2]]
}

#[test]
fn backends_and_forms_agree_and_cloths_have_frames_of_their_own() {
    let Some(device) = support::device() else { return };
    let mut scene = scene(hung());
    scene.cloths.push(hung());
    scene.cloths.push(hung_tube(1));
    scene.cloths.push(hung());
    scene.wind = Some(wind(false));
    // The bound is the distance that a start moved by 1e-6 m leads to on the CPU, so it grows as roundings do.
    let mut nudged = scene.clone();
    for cloth in &mut nudged.cloths {
        let moved = cloth.positions().iter().map(|p| p.map(|x| x + 1e-6 * (1e3 * x).sin())).collect();
        cloth.place(moved).unwrap();
    }
    for fused in [true, false] {
        let options = Options { fused, ..options() };
        let cpu = |scene: &Scene| Rig::cpu(scene.clone(), &options);
        let mut rigs = [cpu(&scene), Rig::gpu(scene.clone(), &options, &device), cpu(&nudged)];
        for n in 0..=10 {
            for rig in &mut rigs {
                for (cloth, pace) in [(0, 1.0), (2, 0.5), (3, -1.0)] {
                    let to = tumbling(pace * f64::from(n) * FRAME, 10.0);
                    rig.stepper.set_moving_frame(cloth, &to).unwrap();
                }
                rig.frames(1);
            }
            for cloth in 0..4 {
                let [cpu, gpu, nudged] = [0, 1, 2].map(|n: usize| rigs[n].positions(cloth));
                let (apart, free) = (largest(&cpu, &gpu), largest(&cpu, &nudged));
                assert!(apart < 4.0 * free, "fused {fused}, cloth {cloth}, frame {n}: {apart}, {free}");
            }
        }
        let apart = largest(&rigs[1].positions(0), &rigs[1].positions(1));
        assert!(apart > 0.01, "the second stands still");
    }
}

#[test]
fn a_dispatch_is_paid_for_only_as_the_frame_accelerates_and_rest_is_rest() {
    let options = Options { sleep: Some(Sleep::default()), ..options() };
    let mut cloth = hung();
    cloth.damping = 3.0;
    let mut stepper = Stepper::on_cpu(scene(cloth), options).unwrap();
    let course =
        FrameMotion { velocity: [5.0, 0.0, 0.0], seconds: FRAME, ..FrameMotion::still(MovingFrame::default()) };
    stepper.put_moving_frame(0, &course).unwrap();
    let at = |n: u32| MovingFrame { position: [5.0 * f64::from(n) * FRAME, 0.0, 0.0], ..MovingFrame::default() };
    for n in 1..=900 {
        stepper.set_moving_frame(0, &at(n)).unwrap();
        stepper.advance(FRAME).unwrap();
    }
    assert!(stepper.is_asleep(0), "on a steady course it rests");
    // The frame stops.
    stepper.advance(FRAME).unwrap();
    assert!(!stepper.is_asleep(0));
}

#[test]
fn what_is_no_frame_is_refused() {
    let mut stepper = Stepper::on_cpu(scene(hung()), options()).unwrap();
    let wrong = [
        MovingFrame { position: [f64::NAN, 0.0, 0.0], ..MovingFrame::default() },
        MovingFrame { rotation: [0.0; 4], ..MovingFrame::default() },
    ];
    for frame in &wrong {
        assert!(stepper.set_moving_frame(0, frame).is_err() && stepper.teleport_moving_frame(0, frame).is_err());
    }
    assert!(stepper.set_moving_frame(1, &MovingFrame::default()).is_err());
    assert_eq!(stepper.moving_frame(0).unwrap(), None);
    assert!(stepper.set_inertia(0, Inertia { linear: 1.5, ..Inertia::default() }).is_err());
    let classic = Options { solver: Solver::Classic, ..options() };
    let mut classic = Stepper::on_cpu(scene(hung()), classic).unwrap();
    assert!(classic.set_moving_frame(0, &MovingFrame::default()).unwrap_err().to_string().contains("xpbd"));
}
