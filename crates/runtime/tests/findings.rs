//! Nothing fails in silence: cloth in trouble is found, and cloth that is well is not.

use gimage_runtime::scene::Pose;
use gimage_runtime::*;

const FRAME: f64 = 1.0 / 60.0;

/// A square of `n` x `n` particles, 1 m wide, `height` above the origin, over its middle.
fn square(n: u32, height: f32) -> Cloth {
    Flat { origin: [-0.5, height, -0.5], ..Flat::square("sheet", n) }.cloth().unwrap()
}

fn scene(cloth: Cloth, colliders: &[Collider]) -> Scene {
    let mut scene = Scene::new("findings");
    scene.cloths.push(cloth);
    scene.colliders = colliders.to_vec();
    scene
}

fn run(scene: Scene, options: Options, frames: u32) -> Stepper {
    let mut stepper = Stepper::on_cpu(scene, Options { threads: 1, ..options }).unwrap();
    (0..frames).for_each(|_| assert!(stepper.advance(FRAME).is_ok()));
    stepper
}

fn ball(radius: f32, center: [f32; 3]) -> Collider {
    Collider { friction: 0.3, ..Collider::new(Shape::Sphere { radius }, center) }
}

fn fates(stepper: &Stepper) -> Vec<Fate> {
    stepper.findings().iter().map(|f| f.fate).collect()
}

#[test]
fn cloth_that_is_well_has_no_findings() {
    for (name, n) in [("s1", 32), ("s2", 32), ("s2f", 64), ("s3", 32)] {
        let stepper = run(scene::builtin(name, n).unwrap(), Options::default(), if name == "s2f" { 12 } else { 90 });
        assert_eq!(fates(&stepper), [], "{name}");
        let (health, worst) = stepper.health(0).unwrap();
        let stretch = health.stretch.unwrap();
        assert!(
            stretch.mean <= stretch.p99 && stretch.p99 <= stretch.max && stretch.p99 <= worst,
            "{name}: {health:?}"
        );
        assert!(health.depth < 1e-4, "{name}: {health:?}");
    }
}

#[test]
fn cloth_that_falls_without_end_is_found_once() {
    let stepper = run(scene(square(9, 0.0), &[]), Options::default(), 190);
    assert_eq!(fates(&stepper), [Fate::Falls]);
    assert!(stepper.findings()[0].to_string().starts_with("cloth 'sheet', at "), "{}", stepper.findings()[0]);
    // A floor, pins, or no gravity.
    let floor = Collider::new(Shape::HalfSpace, [0.0, -0.5, 0.0]);
    assert_eq!(fates(&run(scene(square(9, 0.0), &[floor]), Options::default(), 190)), []);
    let mut pinned = square(9, 0.0);
    pinned.set_pinned(0, true).unwrap();
    assert_eq!(fates(&run(scene(pinned, &[]), Options::default(), 190)), []);
    let afloat = Scene { gravity: [0.0; 3], ..scene(square(9, 0.0), &[]) };
    assert_eq!(fates(&run(afloat, Options::default(), 190)), []);
}

#[test]
fn cloth_that_slides_off_its_body_has_left_it() {
    // One corner on a ball without friction: it touches, and slides off.
    let smooth = Collider::new(Shape::Sphere { radius: 0.2 }, [-0.45, -0.22, -0.45]);
    let stepper = run(scene(square(17, 0.0), &[smooth]), Options::default(), 190);
    assert_eq!(fates(&stepper), [Fate::Left]);
}

#[test]
fn a_ball_that_flies_through_cloth_in_a_frame_is_found() {
    let shot = |substeps| {
        let mut stepper = Stepper::on_cpu(
            scene(square(33, 0.3), &[ball(0.05, [0.0, -0.4, 0.0])]),
            Options { substeps, threads: 1, ..Options::default() },
        )
        .unwrap();
        for frame in 0..20 {
            let y = -0.4 + 0.4 * frame as f32;
            let shot = Collider { velocity: [0.0, 24.0, 0.0], ..ball(0.05, [0.0, y, 0.0]) };
            stepper.set_colliders(vec![shot]).unwrap();
            stepper.advance(FRAME).unwrap();
        }
        (fates(&stepper), stepper.substeps())
    };
    let (found, substeps) = shot(Some(1));
    assert!(
        found.iter().any(|f| matches!(f, Fate::Tunnelled { collider: 0, .. } | Fate::Stretched { .. })),
        "{found:?}"
    );
    assert_eq!(substeps, 2);
    // The default keeps up with the ball.
    assert_eq!(shot(None).1, 64);
}

#[test]
fn a_first_collider_and_a_lost_pin_are_reasons_to_choose_again() {
    let chosen = |s: &Stepper| (s.substeps(), s.choice().polish, s.choice().support);
    let mut pinned = square(32, 0.3);
    pinned.damping = 1.0;
    pinned.set_pinned(0, true).unwrap();
    let mut stepper = run(scene(pinned, &[]), Options::default(), 1);
    assert_eq!(chosen(&stepper), (15, 2, Support::Stirred));
    stepper.set_colliders(vec![ball(0.2, [0.0; 3])]).unwrap();
    assert_eq!(chosen(&stepper), (9, 4, Support::TetheredOnColliders));
    stepper.set_pinned(0, 0, false).unwrap();
    assert!(matches!(chosen(&stepper), (18, 3, Support::Falls(v)) if v > 1.0), "{:?}", chosen(&stepper));
    (0..60).for_each(|_| assert!(stepper.advance(FRAME).is_ok()));
    assert!(stepper.health(0).unwrap().0.stretch.unwrap().p99 < 0.05);
    // Numbers by hand stay.
    let given = Options { substeps: Some(9), ..Options::default() };
    let mut stepper = run(scene(square(32, 0.3), &[]), given, 1);
    stepper.set_colliders(vec![ball(0.2, [0.0; 3])]).unwrap();
    assert_eq!((stepper.substeps(), stepper.choice().polish), (9, 0));
}

#[test]
fn a_host_that_reads_positions_back_finds_the_same() {
    let mut stepper = run(scene(square(9, 0.0), &[]), Options::default(), 1);
    let now = stepper.positions(0).unwrap().to_vec();
    let torn: Vec<_> = now.iter().map(|p| [4.0 * p[0], p[1], p[2], p[3]]).collect();
    let health = stepper.examine(0, &torn, &now).unwrap();
    let stretch = health.stretch.unwrap();
    assert!((stretch.max - 3.0).abs() < 0.01 && stretch.mean > 1.4 && health.speed > 1.0, "{health:?}");
    assert!(matches!(fates(&stepper)[..], [Fate::Stretched { ratio, .. }] if (ratio - 4.0).abs() < 0.01));
    assert!(stepper.examine(1, &now, &now).is_err() && stepper.examine(0, &now[1..], &now).is_err());
}

/// Maps compress cells in corners. A spring there that is many times its rest length can still be shorter than the springs around it.
#[test]
fn a_short_spring_counts_as_torn_where_it_is_three_times_as_long_as_the_mean() {
    let like = square(9, 0.0);
    let side = like.positions()[1][0] - like.positions()[0][0];
    // The spring to the right of the particle in the middle is a third as long as the others.
    let rest = |k: usize| [if k == 40 { side / 3.0 } else { side }, side, 0.0, 0.0];
    let mut cloth = Cloth::new(Parts {
        name: "squeezed".into(),
        grids: like.grids().to_vec(),
        positions: like.positions().to_vec(),
        particles: like.particles().to_vec(),
        rest: Rest::Image((0..81).map(rest).collect()),
        mass: Mass::Constant(0.01),
    })
    .unwrap();
    cloth.velocity = [0.0; 3];
    for (times, torn) in [(3.5, false), (8.5, false), (9.5, true)] {
        let mut stepper = run(scene(cloth.clone(), &[]), Options::default(), 1);
        let mut now: Vec<_> = like.positions().iter().map(|p| [p[0], p[1], p[2], 1.0]).collect();
        // Out of the plane, so that other springs are as long or nearly.
        let far = f32::sqrt((times * side / 3.0).powi(2) - side * side);
        now.iter_mut().enumerate().filter(|(k, _)| k % 9 > 4).for_each(|(_, p)| p[1] += far);
        now.iter_mut().enumerate().filter(|(k, _)| k % 9 == 4 && k / 9 != 4).for_each(|(_, p)| p[1] += 0.5 * far);
        let stretch = stepper.examine(0, &now, &now).unwrap().stretch.unwrap();
        assert!((stretch.max + 1.0 - f64::from(times)).abs() < 0.01, "{stretch:?}");
        let found = fates(&stepper).iter().any(|f| matches!(f, Fate::Stretched { at_pin: false, .. }));
        assert_eq!(found, torn, "{times} times as long: {stretch:?}");
    }
}

#[test]
fn where_colliders_press_the_longest_spring_the_finding_names_them() {
    let far = ball(0.1, [0.0, -5.0, 0.0]);
    let beside = [ball(0.2, [0.0, 0.5, 0.205]), ball(0.2, [0.0, 0.5, -0.205])];
    // Like two along a limb.
    let below = [ball(0.2, [0.05, 0.302, 0.0]), ball(0.2, [-0.05, 0.302, 0.0])];
    for (colliders, names) in [
        (vec![far, beside[0], beside[1]], Some([1, 2])),
        (vec![far, beside[0]], None),
        (vec![far, below[0], below[1]], None),
        (vec![], None),
    ] {
        let mut stepper = run(scene(square(9, 0.0), &colliders), Options::default(), 1);
        let mut now = stepper.positions(0).unwrap().to_vec();
        now[40] = [0.0, 0.5, 0.0, now[40][3]];
        stepper.examine(0, &now, &now).unwrap();
        let found = stepper.findings();
        assert!(
            matches!(found[..], [Finding { fate: Fate::Stretched { between, .. }, .. }] if between == names),
            "{found:?}"
        );
        assert_eq!(found[0].to_string().contains("where colliders 1 and 2 press it"), names.is_some());
    }
}

#[test]
fn where_the_longest_spring_is_at_a_pin_the_finding_says_so() {
    for (pinned, dragged) in [(None, 40), (Some(40), 40), (Some(0), 40), (Some(39), 40)] {
        let mut cloth = square(9, 0.0);
        pinned.into_iter().for_each(|k| cloth.set_pinned(k, true).unwrap());
        let mut stepper = run(scene(cloth, &[]), Options::default(), 1);
        let mut now = stepper.positions(0).unwrap().to_vec();
        now[dragged][1] += 0.6;
        stepper.examine(0, &now, &now).unwrap();
        let is_near = pinned.is_some_and(|k| k.abs_diff(dragged) < 2);
        let found = stepper.findings();
        assert!(
            matches!(found[..], [Finding { fate: Fate::Stretched { at_pin, .. }, .. }] if at_pin == is_near),
            "{found:?}"
        );
        assert_eq!(found[0].to_string().contains("the longest is at a pin"), is_near);
        // Its spring to the right, and those from above and from the left, are as long.
        let spot = found[0].place.as_ref().unwrap();
        let near = [[4, 4], [4, 3], [3, 4]];
        assert!(spot.piece == "sheet" && near.contains(&spot.texel), "{spot:?}");
        assert!(found[0].to_string().contains(&format!("the longest at {spot}")), "{}", found[0]);
    }
}

#[test]
fn cloth_that_begins_inside_a_collider_is_found_with_the_speed_that_it_gets() {
    let floor = |friction| Collider { friction, ..Collider::new(Shape::HalfSpace, [0.0; 3]) };
    let deep = |depth: f32| scene(square(17, -depth), &[ball(0.1, [0.0, 5.0, 0.0]), floor(0.3)]);
    let stepper = run(deep(0.05), Options::default(), 1);
    let found = stepper.findings();
    let Some(Finding { fate: Fate::Thrown { collider: 1, depth, speed }, place: Some(place), .. }) = found.first()
    else {
        panic!("{found:?}");
    };
    let dt = FRAME / f64::from(stepper.substeps());
    assert!((depth - 0.05).abs() < 1e-3 && (speed * dt - 0.05).abs() < 1e-3 && place.piece == "sheet", "{found:?}");
    let text = found[0].to_string();
    assert!(text.contains("inside collider 1") && text.contains("--clear-start on"), "{text}");
    // It tells the truth: so high is a sheet that the start has not cleared.
    let top = |stepper: &Stepper| stepper.positions(0).unwrap().iter().map(|p| p[1]).fold(0.0, f32::max);
    assert!(top(&run(deep(0.05), Options::default(), 20)) > 1.0);
    let mut cleared = deep(0.05);
    cleared.clear_start(&Options::default()).unwrap();
    let stepper = run(cleared, Options::default(), 20);
    assert!(fates(&stepper).is_empty() && top(&stepper) < 0.01, "{:?}", fates(&stepper));
    // A tenth of a millimetre throws nothing.
    let stepper = run(deep(1e-4), Options::default(), 20);
    assert!(fates(&stepper).is_empty() && top(&stepper) < 0.01, "{:?}", fates(&stepper));
}

#[test]
fn a_collider_that_is_put_on_cloth_throws_it_and_one_that_moves_there_does_not() {
    let place = |y: f32| Pose { position: [0.0, y, 0.0], ..Pose::default() };
    let start = || {
        let colliders = [Collider::new(Shape::HalfSpace, [0.0; 3]), ball(0.3, [0.0, -0.5, 0.0])];
        let mut stepper = run(scene(square(17, 0.0), &colliders), Options::default(), 10);
        assert_eq!(fates(&stepper), []);
        stepper.move_collider(1, &place(-0.5)).unwrap();
        stepper
    };
    let is_thrown = |stepper: &Stepper| fates(stepper).iter().any(|f| matches!(f, Fate::Thrown { collider: 1, .. }));
    let mut put = start();
    put.teleport_collider(1, &place(-0.1)).unwrap();
    put.advance(FRAME).unwrap();
    assert!(is_thrown(&put), "{:?}", fates(&put));
    let mut moved = start();
    for n in 1..=40 {
        moved.move_collider(1, &place(-0.5 + 0.01 * n as f32)).unwrap();
        moved.advance(FRAME).unwrap();
    }
    assert!(!is_thrown(&moved), "{:?}", fates(&moved));
    // One more collider is new.
    let mut more = start();
    let mut colliders = more.scene().colliders.clone();
    colliders[1].center = [0.0, -0.1, 0.0];
    colliders.push(ball(0.1, [5.0, 0.0, 0.0]));
    more.set_colliders(colliders).unwrap();
    more.advance(FRAME).unwrap();
    assert!(is_thrown(&more), "{:?}", fates(&more));
}
