//! Cloths that come and go while others keep moving.

use crate::support::rig::{FRAME, Rig};
use crate::support::{self, curtain, hung_tube, made_of, two_charts};
use gimage_runtime::*;

/// Positions now and before and normals of a cloth.
fn bits(rig: &Rig, cloth: ClothHandle) -> [Vec<[u32; 4]>; 3] {
    let cloth = rig.stepper.index(cloth).unwrap();
    let of = |list: Vec<[f32; 4]>| list.into_iter().map(|p| p.map(f32::to_bits)).collect();
    [rig.positions(cloth), rig.previous(cloth), rig.normals(cloth)].map(of)
}

fn options() -> Options {
    Options { substeps: Some(3), sleep: Some(Sleep { speed: 0.05, after: 0.1 }), ..Options::default() }
}

/// A ball, and three cloths: one is dragged by its pins, one falls on the ball, one rests.
fn lasting() -> Scene {
    let mut rests = curtain(8);
    // Beside the cut.
    rests.place(rests.positions().iter().map(|p| [p[0] - 3.0, p[1], p[2]]).collect()).unwrap();
    (rests.damping, rests.thickness) = (20.0, Some(0.01));
    let mut scene = support::scene(curtain(14));
    scene.cloths.extend([two_charts(9), rests]);
    let ball = Collider::new(Shape::Sphere { radius: 0.2 }, [0.5, -0.4, 0.4]);
    scene.colliders.push(Collider { friction: 0.4, ..ball });
    scene
}

/// Cloths of other kinds, one of which meets the ball in its own way.
fn passing() -> [Cloth; 3] {
    let mut thick = curtain(9);
    thick.thickness = Some(0.03);
    [thick, hung_tube(3), curtain(14)]
}

/// Twenty frames of those that last; `come_and_go` is called before each.
fn run(rig: &mut Rig, keep: &[ClothHandle], mut come_and_go: impl FnMut(&mut Rig, u32)) -> Vec<[Vec<[u32; 4]>; 3]> {
    for frame in 0..20 {
        let up = 0.004 * frame as f32;
        rig.stepper.set_pins(keep[0], &[0], &[[0.0, up, 0.0]]).unwrap();
        if frame == 9 {
            rig.stepper.cut([0.6, -0.45, 3.0], [0.3, -0.45, -2.0], [5.0, -0.45, -2.0]).unwrap();
        }
        come_and_go(rig, frame);
        rig.frame_to_its_end(FRAME);
    }
    assert!(rig.stepper.is_asleep(keep[2]) && !rig.stepper.is_asleep(keep[0]), "{}", rig.name());
    keep.iter().map(|cloth| bits(rig, *cloth)).collect()
}

#[test]
fn those_that_stay_move_as_if_no_other_had_been_there() {
    let mut with = lasting();
    // One goes from the front, one from the middle.
    with.cloths.splice(0..0, passing()[..1].to_vec());
    with.cloths.insert(2, passing()[2].clone());
    // With room for whole frames, until the cut.
    let roomy = support::device_with(device_limits);
    let gpu = roomy.map(|device| Rig::gpu(with.clone(), &options(), &device));
    for mut rig in [Some(Rig::cpu(with, &options())), gpu].into_iter().flatten() {
        let mut alone = rig.another(&lasting());
        let all = rig.stepper.handles().to_vec();
        let keep = [all[1], all[3], all[4]];
        let own = alone.stepper.handles().to_vec();
        let expected = run(&mut alone, &own, |_, _| ());
        let mut guests = vec![all[0], all[2]];
        let found = run(&mut rig, &keep, |rig, frame| match frame {
            3 | 4 | 16 => _ = rig.stepper.remove_cloth(guests.remove(0)).unwrap(),
            // Before the cut, in the frame of the cut, after it.
            6 => guests.extend(passing().map(|cloth| rig.stepper.add_cloth(cloth).unwrap())),
            9 | 12 => guests.push(rig.stepper.add_cloth(passing()[1].clone()).unwrap()),
            _ => (),
        });
        assert!(found == expected, "{}", rig.name());
        assert_eq!((guests.len(), rig.stepper.handles().len()), (4, 7));
        // Added cloths have moved, and a cut spares those added after it.
        for (cloth, cut) in guests.iter().zip([true, true, false, false]) {
            let index = rig.stepper.index(*cloth).unwrap();
            let start = rig.stepper.scene().cloths[index].positions().to_vec();
            assert!(rig.positions(index).iter().zip(start).any(|(p, s)| (p[1] - s[1]).abs() > 1e-3));
            assert_eq!(rig.holes(index).is_some(), cut, "{} {index}", rig.name());
        }
    }
}

#[test]
fn a_cloth_that_comes_late_moves_as_at_the_start() {
    let mut cloth = made_of(hung_tube(2));
    cloth.velocity = [0.4, 0.0, 0.2];
    let plain = Options { substeps: Some(3), ..Options::default() };
    let empty = Scene { cloths: Vec::new(), ..lasting() };
    let only = Scene { cloths: vec![cloth.clone()], ..lasting() };
    for (open, late) in [(true, false), (false, true)] {
        let options = if open { Options::default() } else { plain.clone() };
        let before = if late { lasting() } else { empty.clone() };
        for mut fresh in Rig::both(&only, &options) {
            let mut rig = fresh.another(&before);
            rig.frames(4 * u32::from(late));
            let handle = rig.stepper.add_cloth(cloth.clone()).unwrap();
            assert_eq!(rig.stepper.substeps(), fresh.stepper.substeps());
            rig.frames(6);
            fresh.frames(6);
            let expected = bits(&fresh, fresh.stepper.handle(0).unwrap());
            assert!(bits(&rig, handle) == expected, "{}, open {open}", rig.name());
        }
    }
}

#[test]
fn buffers_stay_and_nothing_is_compiled_again() {
    let Some(device) = support::device_with(device_limits) else { return };
    let mut scene = lasting();
    scene.cloths.remove(1);
    // Too large for the memory of a workgroup: by tiles.
    scene.cloths.push(curtain(70));
    let mut rig = Rig::gpu(scene.clone(), &options(), &device);
    let plan = rig.stepper.plan();
    let runs = |what: fn(&Form) -> bool| plan.passes.iter().any(|pass| what(&pass.form));
    assert!(runs(|form| matches!(form, Form::Whole(_))) && runs(|form| matches!(form, Form::Tile(_))));
    rig.frames(2);
    let (compiled, spans) = (rig.stepper.compiled(), |rig: &Rig| {
        let of = |c| rig.stepper.buffers(c).map(|b| (b.now.clone(), b.before.clone(), b.normals.clone()));
        (0..3).map(of).collect::<Vec<_>>()
    });
    let there = spans(&rig);
    let added: Vec<_> = scene.cloths.iter().map(|cloth| rig.stepper.add_cloth(cloth.clone()).unwrap()).collect();
    rig.frames(2);
    assert!(spans(&rig) == there);
    for cloth in &added {
        rig.stepper.remove_cloth(*cloth).unwrap();
    }
    rig.frames(2);
    assert!(spans(&rig) == there);
    // Without the largest of the cloths that share a dispatch too.
    rig.stepper.remove_cloth(0).unwrap();
    rig.frames(2);
    assert_eq!(rig.stepper.compiled(), compiled);
}

/// A curtain that hangs somewhere, moves at some speed, and may meet a limit.
fn guest(n: u32, limited: bool) -> Cloth {
    let mut cloth = curtain(12);
    cloth.place(cloth.positions().iter().map(|p| [p[0] + 2.0 * n as f32, p[1], p[2]]).collect()).unwrap();
    (cloth.velocity, cloth.damping) = ([0.1 * n as f32, 0.0, 0.3], 0.2);
    cloth.limits = limited.then(|| vec![0.05 + 0.01 * n as f32; cloth.len()].into());
    cloth
}

#[test]
fn added_cloths_share_dispatches_and_take_places_that_others_leave() {
    let Some(device) = support::device_with(device_limits) else { return };
    for limited in [false, true] {
        let scene = |guests: &[u32]| {
            let mut scene = lasting();
            scene.cloths.extend(guests.iter().map(|n| guest(*n, limited)));
            scene
        };
        let mut rig = Rig::gpu(lasting(), &options(), &device);
        let own = rig.stepper.plan().dispatches();
        let more = |rig: &Rig| rig.stepper.plan().dispatches() - own;
        let mut added: Vec<_> = (0..20).map(|n| rig.stepper.add_cloth(guest(n, limited)).unwrap()).collect();
        // In buffers of one, one, two, four, eight and sixteen.
        assert_eq!(more(&rig), 6);
        rig.frames(3);
        let buffers = |rig: &Rig, cloth: ClothHandle| rig.stepper.buffers(cloth).unwrap().now.clone();
        let compiled = rig.stepper.compiled();
        // Two go, of which one was the last to come, and others come in their places, one of them moved before it has made a step.
        let places = [7, 19].map(|n| buffers(&rig, added[n]));
        for n in [19, 7] {
            rig.stepper.remove_cloth(added.remove(n)).unwrap();
        }
        let late = [31, 32].map(|n| rig.stepper.add_cloth(guest(n, limited)).unwrap());
        let pose = scene::Pose { position: [0.0, 0.5, 0.0], ..Default::default() };
        rig.stepper.teleport(late[1], &pose).unwrap();
        let found = late.map(|cloth| buffers(&rig, cloth));
        assert!(found[0] == places[0] && found[1].buffer == places[1].buffer, "{places:?} {found:?}");
        assert_eq!((more(&rig), rig.stepper.compiled()), (6, compiled));

        // As in a scene that has them from the start.
        let mut fresh = rig.another(&scene(&[31, 32]));
        fresh.stepper.teleport(4, &pose).unwrap();
        for frame in 0..6 {
            rig.frame(FRAME);
            fresh.frame(FRAME);
            for (n, cloth) in late.iter().enumerate() {
                let expected = bits(&fresh, fresh.stepper.handle(3 + n).unwrap());
                assert!(bits(&rig, *cloth) == expected, "limited {limited}, frame {frame}, guest {n}");
            }
        }
        assert!(rig.stepper.take_faults().is_empty());

        // No cloth comes beside a cut one.
        rig.stepper.cut([0.6, -0.45, 3.0], [0.3, -0.45, -2.0], [5.0, -0.45, -2.0]).unwrap();
        rig.stepper.remove_cloth(late[0]).unwrap();
        let last = rig.stepper.add_cloth(guest(33, limited)).unwrap();
        assert!(buffers(&rig, last).buffer != found[0].buffer);
        rig.frames(2);
        assert!(rig.positions(rig.stepper.index(last).unwrap()).iter().flatten().all(|x| x.is_finite()));
    }
}

#[test]
fn a_game_that_adds_and_removes_garments_needs_no_more_dispatches_or_memory() {
    let Some(device) = support::device_with(device_limits) else { return };
    let mut scene = support::scene(curtain(12));
    scene.cloths = (0..8).map(|n| guest(n, false)).collect();
    let mut rig = Rig::gpu(scene, &options(), &device);
    rig.frames(2);
    let (dispatches, memory) = (rig.stepper.plan().dispatches(), rig.stepper.memory().device_states);
    for n in 0..30 {
        let first = rig.stepper.handles()[n as usize % 8];
        rig.stepper.remove_cloth(first).unwrap();
        rig.stepper.add_cloth(guest(n, false)).unwrap();
        rig.frame(FRAME);
        assert_eq!((rig.stepper.plan().dispatches(), rig.stepper.memory().device_states), (dispatches, memory), "{n}");
    }
    let of = |rig: &Rig, c: usize| rig.positions(c);
    assert!((0..8).all(|c| of(&rig, c).iter().flatten().all(|x| x.is_finite())));
}

#[test]
fn a_handle_is_of_one_cloth_alone() {
    for mut rig in Rig::both(&lasting(), &options()) {
        let (stepper, foreign) = (&mut rig.stepper, Stepper::on_cpu(lasting(), options()).unwrap().handle(1).unwrap());
        let [first, second, third] = stepper.handles()[..] else { panic!("three cloths") };
        let hit = Hit {
            cloth: 0,
            handle: Some(first),
            grid: 0,
            texel: [0; 2],
            triangle: 0,
            particles: [0, 14, 15],
            barycentric: [1.0, 0.0, 0.0],
            corners: [[0.0; 3]; 3],
            distance: 1.0,
        };
        let drag = stepper.grab(&hit).unwrap();
        let removed = stepper.remove_cloth(first).unwrap();
        assert_eq!(removed.len(), 14 * 14);
        // In its place is another one.
        let again = stepper.add_cloth(removed).unwrap();
        assert_eq!(stepper.handles(), [second, third, again]);
        assert_eq!((stepper.index(second).unwrap(), stepper.handle(2).unwrap()), (0, again));
        let before = stepper.snapshot().unwrap();
        for gone in [first, foreign] {
            let state = before.cloths()[0].clone();
            let errors = [
                stepper.set_pins(gone, &[0], &[[0.0; 3]]).unwrap_err(),
                stepper.pin(gone, &[0]).unwrap_err(),
                stepper.set_position(gone, 0, [0.0; 3]).unwrap_err(),
                stepper.transform(gone, &[0], scene::Pose::default().columns()).unwrap_err(),
                stepper.teleport(gone, &scene::Pose::default()).unwrap_err(),
                stepper.set_asleep(gone, true).unwrap_err(),
                stepper.state(gone).unwrap_err(),
                stepper.set_state(gone, &state).unwrap_err(),
                stepper.examine(gone, &[], &[]).unwrap_err(),
                stepper.remove_cloth(gone).unwrap_err(),
                stepper.index(gone).unwrap_err(),
            ];
            for (n, error) in errors.iter().enumerate() {
                assert!(matches!(error, Error::NoCloth(h) if *h == gone), "{n}: {error}");
            }
            assert!(stepper.positions(gone).is_none() && stepper.buffers(gone).is_none());
            assert!(!stepper.is_asleep(gone) && stepper.health(gone).is_none());
        }
        assert!(matches!(stepper.drag(&drag, [0.0; 3]).unwrap_err(), Error::NoCloth(h) if h == first));
        assert!(matches!(stepper.grab(&hit).unwrap_err(), Error::NoCloth(_)));
        assert!(matches!(stepper.release(drag).unwrap_err(), Error::NoCloth(_)));
        assert!(stepper.remove_cloth(3).unwrap_err().to_string().contains("no cloth 3"));
        assert_eq!(stepper.snapshot().unwrap(), before, "nothing has changed");
        // Down to nothing and up again.
        stepper.handles().to_vec().into_iter().for_each(|cloth| _ = stepper.remove_cloth(cloth).unwrap());
        rig.frames(2);
        let back = rig.stepper.add_cloth(curtain(8)).unwrap();
        rig.frames(2);
        assert!(rig.positions(rig.stepper.index(back).unwrap())[60][1] < -0.9);
    }
}

#[test]
fn numbers_rise_for_a_cloth_that_asks_for_more_and_fall_when_it_is_gone() {
    let ground = Collider::new(Shape::HalfSpace, [0.0, -2.0, 0.0]);
    let on_ground = |cloth| Scene { colliders: vec![ground], ..support::scene(cloth) };
    let mut stepper = Stepper::on_cpu(on_ground(curtain(12)), Options::default()).unwrap();
    let start = (stepper.substeps(), stepper.polish());
    stepper.add_cloth(curtain(10)).unwrap();
    assert_eq!((stepper.substeps(), stepper.polish()), start);
    // Cloth that no pin holds asks for more.
    let free = Flat { origin: [0.0, -1.99, 0.0], ..Flat::square("free", 40) }.cloth().unwrap();
    let own = Stepper::on_cpu(on_ground(free.clone()), Options::default()).unwrap();
    assert!(own.substeps() > start.0 && own.polish() > start.1);
    let more = stepper.add_cloth(free).unwrap();
    assert_eq!((stepper.substeps(), stepper.polish()), (own.substeps(), own.polish()));
    assert_eq!(stepper.choice(), own.choice());
    stepper.advance(FRAME).unwrap();
    stepper.remove_cloth(more).unwrap();
    assert_eq!(stepper.polish(), start.1);
    (0..90).for_each(|_| assert!(stepper.advance(FRAME).is_ok()));
    assert_eq!((stepper.substeps(), stepper.polish()), start);
    // Substeps that are too few for springs alone.
    let tethered = Options { substeps: Some(1), ..Options::default() };
    let mut stepper = Stepper::on_cpu(support::scene(curtain(8)), tethered).unwrap();
    let free = stepper.add_cloth(Flat::square("free", 6).cloth().unwrap()).unwrap();
    assert_eq!((stepper.substeps(), stepper.warnings().len()), (2, 1));
    stepper.remove_cloth(free).unwrap();
    assert_eq!((stepper.substeps(), stepper.warnings().len()), (1, 0));
}

#[test]
fn colliders_and_wind_come_and_go() {
    let full =
        Scene { colliders: support::all_colliders(), wind: Some(support::wind(true)), ..support::scene(curtain(9)) };
    let plain = Options { substeps: Some(3), ..Options::default() };
    let bare = Scene { colliders: Vec::new(), wind: None, ..full.clone() };
    for mut there in Rig::both(&full, &plain) {
        let mut rig = there.another(&bare);
        for (colliders, wind) in [(0, false), (2, true), (0, false), (6, true)] {
            for rig in [&mut there, &mut rig] {
                rig.stepper.set_colliders(full.colliders[..colliders].to_vec()).unwrap();
                rig.stepper.set_wind(full.wind.filter(|_| wind)).unwrap();
                rig.frames(2);
            }
        }
        let all = |rig: &Rig| rig.stepper.handles().iter().map(|c| bits(rig, *c)).collect::<Vec<_>>();
        assert!(all(&rig) == all(&there), "{}", rig.name());
    }
}

#[test]
fn an_option_that_cannot_change_is_named() {
    for mut rig in Rig::both(&support::scene(curtain(6)), &Options { fused: false, ..options() }) {
        let given = rig.stepper.options().clone();
        let other = if given.backend == Backend::Cpu { Backend::Gpu } else { Backend::Cpu };
        let wrong = [
            ("backend", Options { backend: other, ..given.clone() }),
            ("solver", Options { solver: Solver::Classic, ..given.clone() }),
            ("tethers", Options { tethers: 1, ..given.clone() }),
            ("pyramid", Options { pyramid: 2, ..given.clone() }),
            ("threads", Options { threads: 3, ..given.clone() }),
            ("fused", Options { fused: true, ..given.clone() }),
        ];
        for (name, options) in wrong {
            let error = rig.stepper.set_options(Options { substeps: Some(7), ..options }).unwrap_err();
            assert!(matches!(error, Error::FixedOption { option } if option == name), "{error}");
            assert!(error.to_string().contains(name));
            assert_eq!((rig.stepper.options(), rig.stepper.substeps()), (&given, 3), "nothing has changed");
        }
        rig.stepper.set_options(Options { backend: Backend::Auto, substeps: Some(7), ..given.clone() }).unwrap();
        assert_eq!((rig.stepper.options().backend, rig.stepper.substeps()), (given.backend, 7));
    }
}
