//! Calls that games make: frames of any length, pins that come late, cloths that go away, two hands at one point.

use crate::support::rig::{FRAME, Rig, largest};
use crate::support::{curtain, scene};
use gimage_runtime::scene::Pose;
use gimage_runtime::*;

/// A sheet of 0.2 m that lies at a height, its middle at x = z = 0.
fn lying(name: &str, n: u32, y: f32) -> Cloth {
    Flat { origin: [-0.1, y, -0.1], right: [0.2, 0.0, 0.0], down: [0.0, 0.0, 0.2], ..Flat::square(name, n) }
        .cloth()
        .unwrap()
}

/// The same with contact.
fn touching(tier: ContactTier, name: &str, n: u32, y: f32) -> Cloth {
    let mut cloth = lying(name, n, y);
    cloth.contact = Some(ClothContact { tier, ..ClothContact::default() });
    cloth
}

/// The largest length of a spring along rows and columns, over that at rest.
fn longest(cloth: &Cloth, now: &[[f32; 4]]) -> f64 {
    let (w, rest) = (cloth.grids()[0].width as usize, cloth.positions());
    let far = |a: &[f32], b: &[f32]| (0..3).map(|c| f64::from(a[c] - b[c]).powi(2)).sum::<f64>().sqrt();
    let ratio = |a: usize, b: usize| far(&now[a], &now[b]) / far(&rest[a], &rest[b]);
    let along = (0..now.len()).filter(|k| k % w + 1 < w).map(|k| ratio(k, k + 1));
    along.chain((0..now.len() - w).map(|k| ratio(k, k + w))).fold(0.0, f64::max)
}

#[test]
fn cloth_on_a_lift_stays_there_at_every_rate() {
    for rate in [60.0, 144.0, 165.0] {
        let mut scene = scene(lying("sheet", 9, 0.21));
        let floor = Collider::new(Shape::Box { half: [1.0, 0.1, 1.0] }, [0.0, 0.1, 0.0]);
        scene.colliders.push(Collider { friction: 0.5, ..floor });
        for mut rig in Rig::both(&scene, &Options::default()) {
            rig.frames(40);
            let (mut y, mut highest) = (0.1f64, 0.0f64);
            for frame in 0..(1.2 * rate) as u32 {
                // Up to 1 m/s, and then on.
                let time = f64::from(frame) / rate;
                y += (2.0 * time).min(1.0) / rate;
                rig.stepper.move_collider(0, &Pose { position: [0.0, y as f32, 0.0], ..Pose::default() }).unwrap();
                rig.frame(1.0 / rate);
                if time > 0.8 {
                    let mean = rig.positions(0).iter().map(|p| f64::from(p[1])).sum::<f64>() / 81.0;
                    highest = highest.max((mean - y - 0.1).abs());
                }
            }
            // The last step ends up to a step before the frame.
            assert!(highest < 0.0035, "{} at {rate} Hz: {highest}", rig.name());
        }
    }
}

#[test]
fn a_collider_that_begins_to_move_between_steps_is_where_it_should_be() {
    let ball = |x: f32| Collider::new(Shape::Sphere { radius: 0.15 }, [x, -0.3, 0.0]);
    let mut scene = scene(curtain(9));
    scene.colliders.push(ball(9.0));
    let options = Options { substeps: Some(8), ..Options::default() };
    let ends = Rig::both(&scene, &options).into_iter().map(|mut rig| {
        // Half a step is left over, and then none.
        rig.frame(FRAME * (1.0 + 0.5 / 8.0));
        let moving = Collider { velocity: [0.0, 0.0, 6.0], ..ball(0.5) };
        rig.stepper.set_colliders(vec![moving]).unwrap();
        rig.frame(FRAME * (1.0 - 0.5 / 8.0));
        rig.positions(0)
    });
    let ends: Vec<_> = ends.collect();
    for other in &ends[1..] {
        assert!(largest(&ends[0], other) < 5e-4, "{}", largest(&ends[0], other));
    }
    assert!(ends[0].iter().any(|p| p[2].abs() > 0.02), "the ball pushes");
}

#[test]
fn a_frame_of_reference_of_constant_velocity_is_not_felt_at_any_rate_nor_in_a_hitch() {
    let velocity = [5.0, 0.0, 0.0];
    for rate in [60.0, 90.0, 165.0] {
        let mut rig = Rig::cpu(scene(curtain(9)), &Options::default());
        rig.frames(200);
        let start = rig.positions(0);
        let at = |time: f64| MovingFrame { position: [5.0 * time, 0.0, 0.0], ..MovingFrame::default() };
        let motion = FrameMotion { velocity, ..FrameMotion::still(at(0.0)) };
        rig.stepper.put_moving_frame(0, &motion).unwrap();
        let (mut time, mut far) = (0.0, 0.0f32);
        for frame in 0..100 {
            // One that takes a quarter of a second.
            let dt = if frame == 50 { 0.25 } else { 1.0 / rate };
            time += dt;
            rig.stepper.set_moving_frame(0, &at(time)).unwrap();
            rig.frame(dt);
            let moved = rig
                .positions(0)
                .iter()
                .zip(&start)
                .flat_map(|(a, b)| [a[0] - b[0], a[1] - b[1], a[2] - b[2]])
                .fold(0.0, |far: f32, x| far.max(x.abs()));
            far = far.max(moved);
        }
        assert!(far < 2e-3, "{rate} Hz: {far}");
    }
}

#[test]
fn cloth_that_is_pinned_late_gets_the_steps_of_cloth_that_hangs() {
    let plain = Flat::square("banner", 33).cloth().unwrap();
    for pins in [(0..33).collect::<Vec<u32>>(), vec![0, 32]] {
        let mut rig = Rig::cpu(scene(plain.clone()), &Options::default());
        assert_eq!(rig.stepper.choice().support, Support::Free);
        rig.stepper.pin(0, &pins).unwrap();
        rig.frames(150);
        assert_eq!(rig.stepper.choice().support, Support::Springs);
        let longest = longest(&plain, &rig.positions(0));
        assert!(longest < 1.08, "{} pins: {longest}", pins.len());
        rig.stepper.unpin(0, &pins).unwrap();
        assert_eq!(rig.stepper.choice().support, Support::Free);
    }
}

#[test]
fn a_cloth_in_front_of_cloths_with_contact_may_leave() {
    for tier in [ContactTier::Safe, ContactTier::Particles] {
        // Crossing at the start, so that they are taken apart.
        let mut tilted = touching(tier, "tilted", 9, 0.0);
        tilted.place(tilted.positions().iter().map(|[x, y, z]| [*x, y + 0.3 * x, z + 0.013]).collect()).unwrap();
        let cloths = [touching(tier, "flat", 9, 0.001), tilted];
        let run = |with: bool| {
            let mut all = scene(lying("beside", 5, 3.0));
            all.cloths.extend(cloths.clone());
            if !with {
                all.cloths.remove(0);
            }
            let mut rig = Rig::cpu(all, &Options { substeps: Some(8), polish: Some(0), ..Options::default() });
            rig.frames(3);
            if with {
                rig.stepper.remove_cloth(0).unwrap();
            }
            rig.frames(20);
            [rig.positions(0), rig.positions(1)]
                .map(|list| list.into_iter().map(|p| p.map(f32::to_bits)).collect::<Vec<_>>())
        };
        assert!(run(true) == run(false), "{tier:?}");
    }
}

#[test]
fn cloth_wakes_as_what_it_lies_on_goes_away() {
    let away = Pose { position: [9.0, 0.0, 0.0], ..Pose::default() };
    let actions: [fn(&mut Stepper, Pose); 2] =
        [|stepper, _| drop(stepper.remove_cloth(0).unwrap()), |stepper, away| stepper.teleport(0, &away).unwrap()];
    for act in actions {
        let mut stack = scene(touching(ContactTier::Particles, "below", 7, 0.02));
        stack.cloths.push(touching(ContactTier::Particles, "above", 7, 0.08));
        stack.cloths.iter_mut().for_each(|cloth| cloth.damping = 3.0);
        stack.colliders.push(Collider { friction: 0.5, ..Collider::new(Shape::HalfSpace, [0.0; 3]) });
        let sleep = Some(Sleep { speed: 0.1, after: 0.3 });
        let mut rig = Rig::cpu(stack, &Options { sleep, ..Options::default() });
        rig.frames(240);
        assert!(rig.stepper.is_asleep(0) && rig.stepper.is_asleep(1));
        let above = rig.stepper.handle(1).unwrap();
        act(&mut rig.stepper, away);
        rig.frames(60);
        let highest = rig.stepper.positions(above).unwrap().iter().map(|p| p[1]).fold(0.0, f32::max);
        assert!(highest < 0.01, "{highest}");
    }
}

#[test]
fn two_hands_may_hold_one_point() {
    let mut rig = Rig::cpu(scene(curtain(9)), &Options::default());
    let pins = |rig: &Rig| rig.positions(0).iter().filter(|p| p[3] == 0.0).count();
    rig.frame(FRAME);
    let before = pins(&rig);
    let hit = rig.stepper.pick([0.02, -0.5, 5.0], [0.0, 0.0, -1.0]).unwrap().unwrap();
    let [one, other] = [0, 1].map(|_| {
        let drag = rig.stepper.grab(&hit).unwrap();
        rig.frame(FRAME);
        drag
    });
    assert_eq!(pins(&rig), before + 3);
    rig.stepper.release(one).unwrap();
    rig.frame(FRAME);
    assert_eq!(pins(&rig), before + 3, "the other hand still holds it");
    rig.stepper.release(other).unwrap();
    rig.frame(FRAME);
    assert_eq!(pins(&rig), before);
}

#[test]
fn cloth_that_starts_inside_a_collider_is_found_on_either_backend() {
    let mut below = scene(Flat { origin: [-0.5, -0.05, -0.5], ..Flat::square("sheet", 17) }.cloth().unwrap());
    below.colliders = vec![Collider::new(Shape::HalfSpace, [0.0; 3])];
    let mut found = Vec::new();
    for mut rig in Rig::both(&below, &Options::default()) {
        (0..2).for_each(|_| rig.frame(FRAME));
        let first = rig.stepper.findings().first().cloned();
        assert!(
            matches!(first, Some(Finding { fate: Fate::Thrown { collider: 0, .. }, .. })),
            "{}: {first:?}",
            rig.name()
        );
        found.extend(first);
    }
    assert!(found.iter().all(|f| f == &found[0]), "{found:?}");
}
