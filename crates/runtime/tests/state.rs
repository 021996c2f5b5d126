//! States of cloths, saved and loaded: the continuation has the same bits.

use crate::support::rig::{FRAME, Rig};
use crate::support::{self, curtain, hung_tube, made_of, two_charts};
use gimage_runtime::scene::{self, Pose};
use gimage_runtime::*;

/// Positions now and before and normals of all cloths.
type Bits = Vec<[Vec<[u32; 4]>; 3]>;

fn bits(rig: &Rig) -> Bits {
    let of = |list: Vec<[f32; 4]>| list.into_iter().map(|p| p.map(f32::to_bits)).collect();
    let cloth = |c| [rig.positions(c), rig.previous(c), rig.normals(c)].map(of);
    (0..rig.stepper.scene().cloths.len()).map(cloth).collect()
}

/// Everything of a state that steppers add up, over seven scenes.
fn scenes() -> Vec<(&'static str, Scene, Options)> {
    let plain = Options::default;
    let mut several = support::scene(curtain(12));
    several.cloths.extend([made_of(hung_tube(3)), two_charts(9)]);
    let mut limited = support::scene(curtain(10));
    limited.cloths[0].limits = Some((0..100).map(|k| if k % 7 == 0 { 0.02 } else { -1.0 }).collect());
    vec![
        ("tethers", scene::builtin("s1", 24).unwrap(), plain()),
        ("several, with seams and a material", several, plain()),
        (
            "a material in wind",
            Scene { wind: Some(support::wind(true)), ..support::scene(made_of(hung_tube(2))) },
            plain(),
        ),
        ("colliders", support::on_colliders(16), Options { substeps: Some(4), ..plain() }),
        ("a pyramid apart", scene::builtin("s1", 20).unwrap(), Options { pyramid: 2, fused: false, ..plain() }),
        ("limits", limited, plain()),
        ("classic", support::on_colliders(12), Options { solver: Solver::Classic, substeps: Some(3), ..plain() }),
        ("error target", support::scene(curtain(12)), Options { quality: Quality::Error(0.01), ..plain() }),
    ]
}

#[test]
fn sixty_frames_after_loading_have_the_same_bits() {
    for (name, scene, options) in scenes() {
        for mut rig in Rig::both(&scene, &options) {
            (0..10).for_each(|_| rig.frame_to_its_end(FRAME));
            // A pin that waits for the next frame is part of the state.
            rig.stepper.set_pinned(0, 7, true).unwrap();
            rig.stepper.set_position(0, 7, [0.3, 0.05, 0.1]).unwrap();
            let saved = rig.stepper.snapshot().unwrap();
            (0..60).for_each(|_| rig.frame_to_its_end(FRAME));
            let (there, substeps) = (bits(&rig), rig.stepper.substeps());
            rig.stepper.set_pinned(0, 7, false).unwrap();
            rig.frame_to_its_end(FRAME);
            let saved = Snapshot::from_bytes(&saved.to_bytes()).unwrap();
            rig.stepper.restore(&saved).unwrap();
            assert_eq!(rig.stepper.snapshot().unwrap(), saved, "{name}, {}", rig.name());
            (0..60).for_each(|_| rig.frame_to_its_end(FRAME));
            assert!(bits(&rig) == there, "{name}, {}", rig.name());
            assert_eq!(rig.stepper.substeps(), substeps, "{name}, {}", rig.name());
        }
    }
}

#[test]
fn another_stepper_goes_on_with_the_same_bits() {
    let scene = &scenes()[1].1;
    for (mut rig, mut other) in
        Rig::both(scene, &Options::default()).into_iter().zip(Rig::both(scene, &Options::default()))
    {
        rig.frames(15);
        let saved = rig.stepper.snapshot().unwrap();
        rig.frames(30);
        other.frames(3);
        other.stepper.restore(&saved).unwrap();
        other.frames(30);
        assert!(bits(&rig) == bits(&other), "{}", rig.name());
    }
}

/// Cuts the upper half from the lower one, from x = 0.3 on.
fn cut(stepper: &mut Stepper) {
    stepper.cut([0.6, -0.45, 3.0], [0.3, -0.45, -2.0], [5.0, -0.45, -2.0]).unwrap();
}

#[test]
fn cuts_are_part_of_a_state() {
    for options in [Options::default(), Options { pyramid: 2, ..Options::default() }] {
        for scene in [support::scene(curtain(14)), support::scene(made_of(curtain(14))), support::scene(two_charts(9))]
        {
            for mut rig in Rig::both(&scene, &options) {
                rig.frames(5);
                let whole = rig.stepper.snapshot().unwrap();
                assert!(whole.cloths()[0].holes().is_none());
                rig.frames(20);
                let never_cut = bits(&rig);
                rig.stepper.restore(&whole).unwrap();
                cut(&mut rig.stepper);
                rig.frames(5);
                let open = rig.stepper.snapshot().unwrap();
                let holes = rig.holes(0).unwrap();
                assert!(holes.iter().any(|h| *h != 0), "{}", rig.name());
                assert_eq!(open.cloths()[0].holes().unwrap(), holes, "{}", rig.name());
                rig.frames(20);
                let was_cut = bits(&rig);
                // Back to the whole cloth; a cut that waits spares it.
                cut(&mut rig.stepper);
                rig.stepper.restore(&whole).unwrap();
                rig.frames(20);
                assert!(rig.holes(0).is_none(), "{}", rig.name());
                assert!(bits(&rig) == never_cut, "{}", rig.name());
                // And to the cut one.
                rig.stepper.restore(&Snapshot::from_bytes(&open.to_bytes()).unwrap()).unwrap();
                rig.frames(20);
                assert_eq!(rig.holes(0).unwrap(), holes, "{}", rig.name());
                assert!(bits(&rig) == was_cut, "{}", rig.name());
            }
        }
    }
}

#[test]
fn a_cloth_sleeps_on_after_loading() {
    let mut cloth = curtain(10);
    cloth.damping = 8.0;
    let options = Options { sleep: Some(Sleep { speed: 0.02, after: 0.25 }), ..Options::default() };
    for mut rig in Rig::both(&support::scene(cloth), &options) {
        let frames = (0..600).find(|_| {
            rig.frame_to_its_end(FRAME);
            rig.stepper.is_asleep(0)
        });
        assert!(frames.is_some());
        let (saved, at) = (rig.stepper.state(0).unwrap(), bits(&rig));
        assert!(saved.is_asleep());
        rig.stepper.set_position(0, 3, [0.3, 0.3, 0.0]).unwrap();
        rig.frames(20);
        assert!(!rig.stepper.is_asleep(0) && bits(&rig) != at, "{}", rig.name());
        rig.stepper.set_state(0, &saved).unwrap();
        rig.frames(5);
        assert!(rig.stepper.is_asleep(0) && rig.stepper.plan().dispatches() == 0, "{}", rig.name());
        assert!(bits(&rig) == at, "{}: normals too", rig.name());
    }
}

#[test]
fn states_cross_backends_and_cloths() {
    let scene = &scenes()[1].1;
    let mut rigs = Rig::both(scene, &Options::default());
    rigs[0].frames(10);
    let saved = rigs[0].stepper.snapshot().unwrap();
    for rig in &mut rigs {
        rig.stepper.restore(&saved).unwrap();
        rig.frame(0.0);
        for (cloth, state) in saved.cloths().iter().enumerate() {
            assert_eq!(rig.positions(cloth), state.positions(), "{}", rig.name());
            assert_eq!(rig.previous(cloth), state.previous(), "{}", rig.name());
        }
    }
    // A second shirt takes the motion of the first.
    let mut crowd = support::scene(curtain(8));
    crowd.cloths.push(curtain(8));
    for mut rig in Rig::both(&crowd, &Options::default()) {
        rig.stepper.set_position(0, 0, [0.1, 0.2, 0.3]).unwrap();
        rig.frames(10);
        assert_ne!(rig.positions(0), rig.positions(1));
        let first = rig.stepper.state(0).unwrap();
        rig.stepper.set_state(1, &first).unwrap();
        rig.frames(10);
        assert_eq!(rig.positions(0), rig.positions(1), "{}", rig.name());
    }
}

#[test]
fn positions_and_velocities_are_plain_arrays() {
    for mut rig in Rig::both(&support::scene(curtain(8)), &Options::default()) {
        let mut state = rig.stepper.state(0).unwrap();
        assert_eq!(state.positions(), rig.positions(0));
        let at: Vec<[f32; 3]> = state.positions().iter().map(|p| [p[0], p[1] + 1.0, p[2]]).collect();
        let velocities = vec![[0.5, 0.0, 1.0]; 64];
        state.set_motion(&at, &velocities).unwrap();
        for v in state.velocities() {
            assert!((0..3).all(|c| (v[c] - [0.5, 0.0, 1.0][c]).abs() < 1e-3), "{v:?}");
        }
        rig.stepper.set_state(0, &state).unwrap();
        rig.frame(FRAME);
        let now = rig.positions(0);
        assert_eq!(now[3][..3], at[3], "{}: pins stay pinned, and where they are put", rig.name());
        assert!(now[60][2] > 0.01 && now[60][1] > -0.1, "{}: {:?}", rig.name(), now[60]);
        assert!(state.set_motion(&at[1..], &velocities).unwrap_err().to_string().contains("63 positions for 64"));
    }
}

#[test]
fn velocities_stay_with_steps_of_another_length() {
    let mut swings = curtain(12);
    swings.velocity = [0.0, 0.0, 1.0];
    for mut rig in Rig::both(&support::scene(swings), &Options { substeps: Some(4), ..Options::default() }) {
        rig.frames(10);
        let saved = rig.stepper.state(0).unwrap();
        rig.stepper.set_options(Options { substeps: Some(10), ..rig.stepper.options().clone() }).unwrap();
        rig.frames(10);
        rig.stepper.set_state(0, &saved).unwrap();
        let loaded = rig.stepper.state(0).unwrap();
        assert!((saved.step() - 2.5 * loaded.step()).abs() < 1e-9);
        let far = |(a, b): (&[f32; 3], &[f32; 3])| (0..3).map(|c| (a[c] - b[c]).abs()).fold(0.0, f32::max);
        let (a, b) = (saved.velocities(), loaded.velocities());
        let (speed, error) = (
            a.iter().flatten().fold(0.0, |most: f32, v| most.max(v.abs())),
            a.iter().zip(&b).map(far).fold(0.0, f32::max),
        );
        // Positions of 1 m have steps of 6e-8 m, in which 1/600 s shows.
        assert!(speed > 0.3 && error < 3e-4, "{}: {speed} {error:e}", rig.name());
    }
}

#[test]
fn what_does_not_fit_is_named_and_changes_nothing() {
    let mut scene = support::scene(curtain(8));
    scene.cloths.push(two_charts(9));
    for mut rig in Rig::both(&scene, &Options::default()) {
        rig.frames(5);
        let before = rig.stepper.snapshot().unwrap();
        let other = rig.stepper.state(1).unwrap();
        let error = rig.stepper.set_state(0, &other).unwrap_err();
        assert!(matches!(error, Error::State { problem: StateProblem::Grids { .. }, .. }));
        let text = error.to_string();
        assert!(text.contains("curtain") && text.contains("9 x 9, 9 x 9") && text.contains("8 x 8"), "{text}");
        assert!(rig.stepper.set_state(2, &other).unwrap_err().to_string().contains("no cloth 2"));
        // A hole in the grid.
        let mut parts = Parts {
            name: "torn".into(),
            grids: scene.cloths[0].grids().to_vec(),
            positions: scene.cloths[0].positions().to_vec(),
            particles: scene.cloths[0].particles().to_vec(),
            rest: scene.cloths[0].rest().clone(),
            mass: Mass::Constant(1e-3),
        };
        parts.particles[20] = Particle::None;
        let torn =
            Stepper::on_cpu(support::scene(Cloth::new(parts).unwrap()), Options::default()).unwrap().state(0).unwrap();
        let error = rig.stepper.set_state(0, &torn).unwrap_err();
        assert!(matches!(error, Error::State { problem: StateProblem::Particle { index: 20 }, .. }), "{error}");
        // NaN, after a good first cloth: neither is loaded.
        let mut bad = before.cloths()[1].clone();
        let mut at: Vec<[f32; 3]> = bad.positions().iter().map(|p| [p[0], p[1], p[2]]).collect();
        at[100][1] = f32::NAN;
        bad.set_motion(&at, &vec![[0.0; 3]; at.len()]).unwrap();
        let error = rig.stepper.set_state(1, &bad).unwrap_err();
        assert!(
            matches!(error, Error::NotFinite { index: 100, .. }) && error.to_string().contains("charts"),
            "{error}"
        );
        let alone = Stepper::on_cpu(support::scene(curtain(8)), Options::default()).unwrap().snapshot().unwrap();
        let error = rig.stepper.restore(&alone).unwrap_err();
        assert!(
            matches!(error, Error::State { problem: StateProblem::Cloths { found: 1, expected: 2 }, .. }),
            "{error}"
        );
        assert_eq!(rig.stepper.snapshot().unwrap(), before, "{}", rig.name());
    }
    // A cut with other tethers.
    let run = |tethers| {
        let mut stepper =
            Stepper::on_cpu(support::scene(curtain(14)), Options { tethers, ..Options::default() }).unwrap();
        cut(&mut stepper);
        stepper.advance(FRAME).unwrap();
        stepper
    };
    let error = run(0).set_state(0, &run(2).state(0).unwrap()).unwrap_err();
    assert!(matches!(error, Error::State { problem: StateProblem::Tethers { expected: 0, .. }, .. }), "{error}");
}

#[test]
fn damaged_bytes_of_a_state_are_refused() {
    let mut stepper =
        Stepper::on_cpu(support::scene(curtain(14)), Options { tethers: 2, ..Options::default() }).unwrap();
    cut(&mut stepper);
    stepper.advance(FRAME).unwrap();
    // The last of all words are tethers: an anchor, and its distance.
    let good = stepper.state(0).unwrap().to_bytes();
    let mut refused = 0;
    for n in 1..=2 * 14 * 14 {
        let mut bytes = good.clone();
        let at = bytes.len() - 4 * n;
        let is_anchor = n % 2 == 0;
        bytes[at..at + 4].copy_from_slice(&4000u32.to_le_bytes());
        let set = ClothState::from_bytes(&bytes).and_then(|state| stepper.set_state(0, &state));
        assert_eq!(
            is_anchor,
            matches!(set, Err(Error::State { problem: StateProblem::Anchor { .. }, .. })),
            "{n}: {set:?}"
        );
        refused += u32::from(is_anchor);
        stepper.advance(FRAME).unwrap();
    }
    assert!(refused > 100, "{refused}");
    // Substeps of cloth at rest, among the numbers of a snapshot.
    let snapshot = stepper.snapshot().unwrap().to_bytes();
    let lasting = f64::from(stepper.substeps()).to_le_bytes();
    let places: Vec<usize> = (0..snapshot.len() - 8).filter(|at| snapshot[*at..*at + 8] == lasting).collect();
    assert!(!places.is_empty());
    let spoilt = places.into_iter().map(|at| {
        let mut bytes = snapshot.clone();
        bytes[at..at + 8].copy_from_slice(&1e12f64.to_le_bytes());
        Snapshot::from_bytes(&bytes)
    });
    assert!(spoilt.into_iter().any(|read| read.is_err()));
}

#[test]
fn rounds_that_an_error_chooses_beside_given_substeps_are_part_of_a_snapshot() {
    let options = Options { substeps: Some(4), quality: Quality::Error(0.02), tethers: 0, ..Options::default() };
    let sheet = || scene::builtin("s1", 32).unwrap();
    let mut stepper = Stepper::on_cpu(sheet(), options.clone()).unwrap();
    for _ in 0..1800 {
        stepper.advance(FRAME).unwrap();
        if stepper.polish() > 0 {
            break;
        }
    }
    let (snapshot, polish) = (stepper.snapshot().unwrap(), stepper.polish());
    let fresh = Stepper::on_cpu(sheet(), options).unwrap();
    assert_ne!(fresh.polish(), polish);
    let mut again = fresh;
    again.restore(&snapshot).unwrap();
    assert_eq!(again.polish(), polish);
    for _ in 0..30 {
        stepper.advance(FRAME).unwrap();
        again.advance(FRAME).unwrap();
    }
    assert_eq!(again.snapshot().unwrap(), stepper.snapshot().unwrap());
}

fn buffer(device: &wgpu::Device, size: u64, usage: wgpu::BufferUsages) -> wgpu::Buffer {
    device.create_buffer(&wgpu::BufferDescriptor { label: None, size, usage, mapped_at_creation: false })
}

#[test]
fn a_state_goes_through_a_buffer_without_a_wait() {
    use wgpu::BufferUsages as Usage;
    let Some((device, queue)) = support::device() else { return };
    let handles = (device.clone(), queue.clone());
    let mut several = scenes().swap_remove(1).1;
    // Too large for a workgroup's memory: by tiles.
    several.cloths.push(curtain(70));
    // The pin that is moved stirs cloth, which would then have shorter steps than the state that is saved.
    let fixed = Options { substeps: Some(8), polish: Some(2), ..Options::default() };
    for (options, torn) in [(fixed.clone(), false), (Options { fused: false, ..fixed }, true)] {
        let mut rig = Rig::gpu(several.clone(), &options, &handles);
        rig.frames(5);
        if torn {
            cut(&mut rig.stepper);
            rig.frames(2);
        }
        rig.stepper.set_position(0, 2, [0.2, 0.1, 0.0]).unwrap();
        let mut encoder = device.create_command_encoder(&Default::default());
        let saved: Vec<SavedState> = (0..several.cloths.len())
            .map(|cloth| {
                let size = rig.stepper.state_bytes(cloth).unwrap();
                let place = buffer(&device, size + 8, Usage::COPY_DST | Usage::COPY_SRC);
                rig.stepper.record_state(&mut encoder, cloth, &place, 8).unwrap()
            })
            .collect();
        queue.submit([encoder.finish()]);
        let there = rig.stepper.snapshot().unwrap();
        rig.frames(20);
        let expected = bits(&rig);
        if !torn {
            cut(&mut rig.stepper);
            rig.frames(2);
        }
        let mut encoder = device.create_command_encoder(&Default::default());
        for (cloth, saved) in saved.iter().enumerate() {
            rig.stepper.record_set_state(&mut encoder, cloth, saved).unwrap();
        }
        queue.submit([encoder.finish()]);
        for (cloth, saved) in saved.iter().enumerate() {
            let bytes = read_back_u32(&device, &queue, saved.span()).unwrap();
            let read = saved.read(&bytes.iter().flat_map(|w| w.to_ne_bytes()).collect::<Vec<_>>()).unwrap();
            assert_eq!(read, there.cloths()[cloth], "{cloth}");
            assert!(saved.read(&[0; 12]).is_err());
        }
        rig.frames(20);
        assert!(bits(&rig) == expected, "{options:?}");
        // Impossible requests are refused before anything is recorded.
        let size = rig.stepper.state_bytes(0).unwrap();
        let mut encoder = device.create_command_encoder(&Default::default());
        for (place, offset, words) in [
            (buffer(&device, size, Usage::COPY_DST), 4, "make it larger"),
            (buffer(&device, size, Usage::COPY_SRC), 0, "make it with the usage"),
            (buffer(&device, size + 2, Usage::COPY_DST), 2, "multiple of 4"),
        ] {
            let error = rig.stepper.record_state(&mut encoder, 0, &place, offset).unwrap_err().to_string();
            assert!(error.contains(words) && error.contains("curtain"), "{error}");
        }
        let place = buffer(&device, size, Usage::COPY_DST);
        let kept = rig.stepper.record_state(&mut encoder, 0, &place, 0).unwrap();
        assert!(rig.stepper.record_set_state(&mut encoder, 0, &kept).is_err(), "no COPY_SRC");
        assert!(rig.stepper.record_set_state(&mut encoder, 1, &saved[0]).unwrap_err().to_string().contains("grids"));
        queue.submit([encoder.finish()]);
    }
    let cpu = Options { backend: Backend::Cpu, ..Options::default() };
    let mut stepper = Stepper::new(several, cpu, Some((&device, &queue))).unwrap();
    let mut encoder = device.create_command_encoder(&Default::default());
    let place = buffer(&device, 1 << 20, Usage::COPY_DST);
    let error = stepper.record_state(&mut encoder, 0, &place, 0).unwrap_err().to_string();
    assert!(error.contains("use Stepper::state"), "{error}");
}

#[test]
fn a_teleport_stirs_nothing() {
    let by = Pose { position: [0.25, 0.5, -0.125], rotation: scene::about([0.0, 1.0, 0.0], 1.0) };
    let mut limited = curtain(14);
    limited.limits = Some(vec![0.05; 196].into());
    let mut swings = made_of(curtain(14));
    swings.velocity = [0.0, 0.0, 1.0];
    let mut charts = two_charts(9);
    charts.pin(&charts.select(&Select::Box { low: [-1.0, -0.01, -1.0], high: [2.0; 3] }).unwrap()).unwrap();
    for cloth in [curtain(14), swings, charts, limited] {
        let scene = support::scene(cloth.clone());
        let rigs = || Rig::both(&scene, &Options::default());
        for (mut rig, mut still) in rigs().into_iter().zip(rigs()) {
            // Gravity points along the axis of the turn.
            rig.frames(10);
            still.frames(10);
            rig.stepper.teleport(0, &by).unwrap();
            let (a, b) = (rig.stepper.state(0).unwrap(), still.stepper.state(0).unwrap());
            let far = |a: [f32; 3], b: [f32; 3]| (0..3).map(|c| (a[c] - b[c]).abs()).fold(0.0, f32::max);
            let turn = Pose { position: [0.0; 3], ..by };
            for (v, w) in a.velocities().iter().zip(b.velocities()) {
                assert!(far(*v, turn.apply(w)) < 1e-3, "{}: {v:?} {w:?}", rig.name());
            }
            // Not for long: a flat sheet is stiff in its plane and swings out of it to where rounding pushes it.
            rig.frames(3);
            still.frames(3);
            let xyz = |p: [f32; 4]| [p[0], p[1], p[2]];
            let error = rig
                .positions(0)
                .iter()
                .zip(still.positions(0))
                .map(|(p, q)| far(xyz(*p), by.apply(xyz(q))))
                .fold(0.0, f32::max);
            assert!(error < 1e-4, "{} {}: {error:e}", cloth.name(), rig.name());
            // A state knows where limits are.
            let saved = rig.stepper.state(0).unwrap();
            rig.frames(10);
            let there = bits(&rig);
            rig.stepper.teleport(0, &by).unwrap();
            rig.frames(10);
            rig.stepper.set_state(0, &saved).unwrap();
            rig.frames(10);
            assert!(bits(&rig) == there, "{} {}", cloth.name(), rig.name());
        }
    }
    let mut stepper = Stepper::on_cpu(support::scene(curtain(8)), Options::default()).unwrap();
    assert!(stepper.teleport(1, &by).is_err());
    assert!(stepper.teleport(0, &Pose { rotation: [0.0; 4], ..by }).is_err());
    assert!(stepper.teleport(0, &Pose { position: [f32::NAN; 3], ..by }).is_err());
    // Free cloth that is taken far down has not fallen.
    let mut sheet =
        Stepper::on_cpu(support::scene(Flat::square("sheet", 8).cloth().unwrap()), Options::default()).unwrap();
    sheet.teleport(0, &Pose { position: [0.0, -50.0, 0.0], ..Pose::default() }).unwrap();
    (0..20).for_each(|_| assert!(sheet.advance(FRAME).is_ok()));
    assert!(sheet.findings().is_empty(), "{:?}", sheet.findings());
}
