//! Whole frames in one dispatch against the passes that they are made of, and cloths that share it.

use std::collections::HashSet;

use crate::support::alike::{rounding, tolerates};
use crate::support::rig::FRAME;
use crate::support::run::{Device, Run};
use crate::support::{self, device_with, scene};
use gimage_runtime::*;

fn roomy() -> Option<Device> {
    device_with(device_limits)
}

fn options(fused: bool) -> Options {
    Options { solver: Solver::Xpbd, backend: Backend::Gpu, substeps: Some(6), fused, ..Options::default() }
}

#[test]
fn one_dispatch_gives_the_bits_of_separate_passes() {
    let Some(device) = roomy() else { return };
    for (name, scene) in [support::outside(), support::soft()].concat() {
        for (iterations, polish) in [(1, 0), (2, 0), (1, 1), (2, 2)] {
            let with = |fused| Options { iterations, polish: Some(polish), ..options(fused) };
            let one = Run::new(&scene, &with(true), &device);
            assert_eq!((one.stepper.plan().passes.len(), one.holds().len()), (1, 1), "{name}");
            let apart = Run::new(&scene, &with(false), &device);
            assert_eq!(apart.holds(), [], "{name}");
            assert!(one.frames(30).bits(0) == apart.frames(30).bits(0), "{name}");
        }
    }
}

#[test]
fn one_dispatch_has_the_passes_on_coarser_grids() {
    let Some(device) = roomy() else { return };
    // Cloth that meets colliders has no pyramid.
    let all = [support::outside(), support::soft()].concat().into_iter();
    for (name, scene) in all.filter(|(_, scene)| scene.colliders.is_empty()) {
        for (pyramid, iterations) in [(1, 1), (2, 2)] {
            let with = |fused| Options { pyramid, iterations, tethers: 0, ..options(fused) };
            let one = Run::new(&scene, &with(true), &device);
            assert_eq!((one.stepper.plan().passes.len(), one.holds().len()), (1, 1), "{name}");
            let apart = Run::new(&scene, &with(false), &device);
            let nodes = |p: &PlannedPass| p.shader == "refine";
            assert!(apart.stepper.plan().passes.iter().any(nodes), "{name}");
            assert!(one.frames(8).bits(0) == apart.frames(8).bits(0), "{name}, every {pyramid}");
        }
    }
}

#[test]
fn where_positions_are_held_changes_nothing() {
    // Memory for 585 particles at 28 bytes, 1024 at 16, 1365 at 12.
    let Some(default) = support::device() else { return };
    let memory = default.0.limits().max_compute_workgroup_storage_size;
    // Of 16 x 16 particles a thread of the smallest workgroup has four, which is few enough for registers.
    for (n, hold) in [(16, Hold::Both), (24, Hold::Both), (32, Hold::Wide), (36, Hold::Narrow)] {
        assert_eq!(memory, 16_384, "the default of WebGPU");
        let scene = scene::builtin("s1", n).unwrap();
        let one = Run::new(&scene, &options(true), &default);
        assert_eq!(one.holds(), [hold]);
        let apart = Run::new(&scene, &options(false), &default);
        assert!(one.frames(20).bits(0) == apart.frames(20).bits(0), "{n}");
    }
    // Where positions fill the memory, the list of colliders that are near lies elsewhere.
    let mut crowded = scene(Flat { origin: [-0.3, 0.1, -0.2], ..Flat::square("flat", 32) }.cloth().unwrap());
    crowded.cloths[0].velocity = [0.0, -3.0, 0.5];
    crowded.colliders = crowd(40);
    let one = Run::new(&crowded, &options(true), &default);
    let full = |p: &PlannedPass| matches!(p.form, Form::Whole(Fused { full: true, hold: Hold::Wide, .. }));
    assert!(one.stepper.plan().passes.iter().any(full));
    let apart = Run::new(&crowded, &options(false), &default);
    assert!(one.frames(10).bits(0) == apart.frames(10).bits(0));
    // One that is too large runs by tiles, however many there are.
    let large = |count: usize| {
        let mut scene = scene::builtin("s1", 40).unwrap();
        scene.cloths = vec![scene.cloths[0].clone(); count];
        scene
    };
    for count in [1, 2, 16] {
        assert_eq!(Run::new(&large(count), &options(true), &default).holds(), [], "{count}");
    }
}

/// Two sheets in gusts on triangles, the second so light that forces of air stand for fewer steps.
fn windy(n: u32) -> Scene {
    let cloths = [0.2, 0.02].map(|mass| {
        let mut cloth = Flat { mass, ..Flat::square("sheet", n) }.cloth().unwrap();
        cloth.set_pinned(0, true).unwrap();
        cloth
    });
    Scene { cloths: cloths.into(), wind: Some(support::wind(true)), ..Scene::new("windy") }
}

#[test]
fn forces_of_air_stand_as_long_in_every_form_and_on_both_backends() {
    let Some(device) = roomy() else { return };
    let with = |fused| Options { substeps: Some(32), ..options(fused) };
    let scene = windy(17);
    let apart = Run::new(&scene, &with(false), &device);
    let blows = |p: &&PlannedPass| matches!(p.form, Form::Apart(Pass::Wind { .. }));
    let counts: Vec<u32> = apart.stepper.plan().passes.iter().filter(blows).map(|p| p.dispatches).collect();
    assert_eq!(counts, [4, 32], "once in 8 steps of the heavy one, in every step of the light one");
    let one = Run::new(&scene, &with(true), &device);
    assert_eq!(one.stepper.plan().dispatches(), 1);
    let (one, apart) = (one.whole_frames(6), apart.whole_frames(6));
    let mut cpu = Stepper::on_cpu(scene, Options { backend: Backend::Cpu, ..with(true) }).unwrap();
    (0..6).for_each(|_| assert!(cpu.advance(FRAME).is_ok()));
    for cloth in 0..2 {
        assert!(one.bits(cloth) == apart.bits(cloth), "{cloth}");
        let here = one.bits(cloth)[0].iter().map(|p| p.map(f32::from_bits)).collect::<Vec<_>>();
        let off = here.iter().zip(cpu.positions(cloth).unwrap());
        let off = off.map(|(a, b)| (0..3).map(|c| (a[c] - b[c]).abs()).fold(0.0, f32::max)).fold(0.0, f32::max);
        assert!(off < 1e-4, "{cloth}: {off}");
    }
}

/// Cloths of many sizes, seamed and not, soft and not, pinned and free, each with its own damping.
fn wardrobe() -> Scene {
    let mut all = scene::builtin("s1", 9).unwrap();
    for n in [5, 12, 23, 17] {
        all.cloths.extend(scene::builtin("s1", n).unwrap().cloths);
        all.cloths.push(support::hung_tube(2 + n % 3));
        all.cloths.push(Flat { right: [0.8, 0.0, 0.1], ..Flat::square("free", n) }.cloth().unwrap());
        all.cloths.extend(scene::builtin("s1k", n).unwrap().cloths);
        all.cloths.push(support::two_charts(n));
        all.cloths.push(support::made_of(support::two_charts(n)));
    }
    for (k, cloth) in all.cloths.iter_mut().enumerate() {
        cloth.damping = 0.1 * k as f32;
        cloth.velocity = [0.2, 0.0, 0.1 * k as f32];
    }
    all.colliders = vec![Collider { friction: 0.3, ..Collider::new(Shape::HalfSpace, [0.0, -0.4, 0.0]) }];
    all
}

#[test]
fn cloths_that_share_a_dispatch_move_as_they_would_alone() {
    let Some(device) = roomy() else { return };
    let all = wardrobe();
    let together = Run::new(&all, &options(true), &device);
    let plan = together.stepper.plan();
    // Kinds: s1, tubes, free ones, soft ones, charts, charts of a material. Where the memory of a workgroup is small, cloths
    // of a kind are held in different ways, and only those that are held alike share a dispatch.
    let kind = |cloth: usize| cloth.saturating_sub(1) % 6;
    let fused = |p: &PlannedPass| if let Form::Whole(f) = &p.form { Some((kind(p.cloth), f.hold)) } else { None };
    let batches: HashSet<_> = plan.passes.iter().filter_map(fused).collect();
    let shared = plan.passes.iter().filter(|p| fused(p).is_some());
    assert_eq!(shared.map(|p| p.dispatches as usize).sum::<usize>(), batches.len(), "{plan}");
    let (limits, apart) = (device.0.limits(), all.cloths.len() - together.holds().len());
    // 28 bytes for each particle of the largest cloth.
    let (buffers, memory) = (8, 28 * 1088);
    if limits.max_storage_buffers_per_shader_stage >= buffers {
        assert_eq!(apart, 0, "{plan}");
    } else {
        let found = limits.max_storage_buffers_per_shader_stage;
        support::skip(&format!("{apart} cloths run apart: {found} storage buffers, and {buffers} are needed"));
    }
    if limits.max_compute_workgroup_storage_size >= memory {
        assert!(batches.iter().all(|(_, hold)| *hold == Hold::Both), "{plan}");
    }
    if apart == 0 && limits.max_compute_workgroup_storage_size >= memory {
        assert_eq!(plan.dispatches(), 6, "{plan}");
    }
    let together = together.frames(8);
    for (index, cloth) in all.cloths.iter().enumerate() {
        let alone = Scene { cloths: vec![cloth.clone()], ..all.clone() };
        let alone = Run::new(&alone, &options(false), &device).frames(8);
        assert!(together.bits(index) == alone.bits(0), "cloth {index}");
    }
    let again = Run::new(&all, &options(true), &device).frames(8);
    assert!((0..all.cloths.len()).all(|c| again.bits(c) == together.bits(c)));
}

/// Seams, tethers, limits, compliance summed over relaxations, materials, wind on triangles, friction: no scene needs more.
#[test]
fn every_garment_runs_whole_frames_at_the_limits_of_webgpu() {
    let Some(default) = support::device() else { return };
    assert_eq!(default.0.limits().max_storage_buffers_per_shader_stage, 8, "the default of WebGPU");
    let mut all = wardrobe();
    for cloth in all.cloths.iter_mut().step_by(2) {
        cloth.limits = Some(vec![0.3; cloth.len()].into());
    }
    let shape = Shape::Capsule { radius: 0.1, half_height: 0.2 };
    all.colliders.push(Collider { friction: 0.5, ..Collider::new(shape, [0.4, -0.2, 0.4]) });
    for triangles in [false, true] {
        all.wind = Some(support::wind(triangles));
        let with = |fused| Options { iterations: 2, polish: Some(1), ..options(fused) };
        let one = Run::new(&all, &with(true), &default);
        assert_eq!(one.holds().len(), all.cloths.len(), "{}", one.stepper.plan());
        let bound = |p: &PlannedPass| p.bindings.iter().filter(|b| !["frame", "batch", "part"].contains(&b.0)).count();
        let most = one.stepper.plan().passes.iter().map(bound).max();
        assert_eq!(most, Some(8));
        let (one, apart) = (one.frames(6), Run::new(&all, &with(false), &default).frames(6));
        assert!((0..all.cloths.len()).all(|c| one.bits(c) == apart.bits(c)), "triangles: {triangles}");
    }
}

#[test]
fn a_thousand_cloths_are_one_dispatch() {
    let Some(device) = roomy() else { return };
    let mut all = scene::builtin("s1", 7).unwrap();
    all.cloths = (0..1000).map(|k| scene::builtin("s1", 4 + k % 5).unwrap().cloths.remove(0)).collect();
    let together = Run::new(&all, &options(true), &device);
    assert_eq!(together.stepper.plan().dispatches(), 1);
    let together = together.frames(5);
    for cloth in [0, 4, 999] {
        let alone = scene(all.cloths[cloth].clone());
        assert!(together.bits(cloth) == Run::new(&alone, &options(true), &device).frames(5).bits(0), "{cloth}");
    }
}

#[test]
fn what_is_done_to_one_cloth_is_done_to_it_alone() {
    let Some(device) = roomy() else { return };
    let run = |fused| {
        let mut run = Run::new(&wardrobe(), &options(fused), &device).frames(4);
        let s = &mut run.stepper;
        s.set_asleep(1, true).unwrap();
        s.set_pinned(6, 7, true).unwrap();
        s.set_position(6, 7, [0.3, 0.2, 0.1]).unwrap();
        let mut run = run.frames(3);
        let turn = [[0.0, 1.0, 0.0, 0.0], [-1.0, 0.0, 0.0, 0.0], [0.0, 0.0, 1.0, 0.0], [0.1, 0.0, 0.0, 1.0]];
        run.stepper.transform(4, &[3, 4, 5], turn).unwrap();
        let mut encoder = device.0.create_command_encoder(&Default::default());
        let ticket = run.stepper.record_pick(&mut encoder, [0.31, 4.0, 0.12], [0.01, -1.0, 0.02]).unwrap();
        device.1.submit([encoder.finish()]);
        let hit = ticket.wait(&device.0).unwrap().unwrap();
        run.stepper.set_asleep(1, false).unwrap();
        run.stepper.set_wind(Some(support::wind(false))).unwrap();
        let mut run = run.frames(3);
        // A cut is made by passes of its own.
        run.stepper.set_wind(Some(support::wind(true))).unwrap();
        let mut run = run.frames(3);
        run.stepper.set_wind(None).unwrap();
        run.stepper.set_options(Options { iterations: 2, normals: false, ..run.stepper.options().clone() }).unwrap();
        let mut run = run.frames(3);
        run.stepper.set_options(Options { iterations: 1, normals: true, ..run.stepper.options().clone() }).unwrap();
        run.stepper.cut([0.5, 0.5, 3.0], [-4.0, -0.1, -2.0], [5.0, -0.1, -2.0]).unwrap();
        let run = run.frames(3);
        ((0..wardrobe().cloths.len()).map(|c| run.bits(c)).collect::<Vec<_>>(), hit)
    };
    let ((one, hit), (apart, hit_apart)) = (run(true), run(false));
    // Steppers name their cloths differently.
    let hit = Hit { handle: hit_apart.handle, ..hit };
    if tolerates(&device) {
        assert_eq!((hit.cloth, hit.particles), (hit_apart.cloth, hit_apart.particles));
    } else {
        assert_eq!(hit, hit_apart);
    }
    for (cloth, (a, b)) in one.iter().zip(&apart).enumerate() {
        assert!(a == b, "cloth {cloth}");
    }
}

#[test]
fn colliders_that_move_are_where_they_are_in_every_step() {
    let Some(device) = roomy() else { return };
    let mut hit = scene(support::curtain(24));
    let shape = Shape::Sphere { radius: 0.1 };
    hit.colliders = vec![Collider {
        velocity: [0.0, 0.0, 9.0],
        spin: [3.0, 1.0, 0.0],
        friction: 0.4,
        ..Collider::new(shape, [0.5, -0.5, 0.1])
    }];
    // Above 128 steps per frame some share their place.
    for (substeps, iterations) in [(1, 1), (7, 1), (300, 1), (300, 16)] {
        let with = |fused| Options { substeps: Some(substeps), iterations, ..options(fused) };
        let dispatches = Run::new(&hit, &with(true), &device).stepper.plan().dispatches();
        assert!(dispatches > 1 || iterations == 1, "{substeps} steps: {dispatches}");
        let [one, apart] = [true, false].map(|fused| Run::new(&hit, &with(fused), &device).frames(3).bits(0));
        assert!(one == apart, "{substeps} steps");
    }
}

/// A dispatch that does not end is taken for lost.
#[test]
fn a_frame_with_much_work_is_several_dispatches_with_the_same_bits() {
    let Some(device) = roomy() else { return };
    let seams = [("tube", scene(support::hung_tube(3))), ("charts", scene(support::two_charts(17)))];
    let large = [("curtain", scene(support::curtain(40)))];
    let small = [seams.to_vec(), vec![("windy", windy(17))], support::soft()].concat();
    // More than 2^21 relaxations of a particle in 1,600, and long loops in few.
    let (most, [few, many]) = (1 << 21, [(130, 17), (44, 32)]);
    for ((name, scene), (substeps, iterations)) in
        small.into_iter().map(|s| (s, few)).chain(large.into_iter().map(|s| (s, many)))
    {
        let with = |fused| Options { substeps: Some(substeps), iterations, ..options(fused) };
        let one = Run::new(&scene, &with(true), &device);
        let largest = scene.cloths.iter().map(|c| c.len().next_multiple_of(64) as u32).max().unwrap();
        let (dispatches, least) = (one.stepper.plan().dispatches(), substeps.div_ceil(most / (iterations * largest)));
        assert!(dispatches >= least && (least > 1 || largest < 1000), "{name}: {dispatches}, {least}");
        let (one, apart) = (one.frames(2), Run::new(&scene, &with(false), &device).frames(2));
        assert!((0..scene.cloths.len()).all(|c| one.bits(c) == apart.bits(c)), "{name}");
    }
}

/// As many as a frame has dispatches, and more than lie ready.
#[test]
fn numbers_of_all_dispatches_of_a_frame_have_room() {
    let Some(device) = roomy() else { return };
    let mut all = scene(support::curtain(5));
    let ball = |group: u32| {
        let shape = Shape::Sphere { radius: 0.2 + 0.05 * group as f32 };
        // They move, so that each step has a row of numbers.
        let velocity = [0.0, 0.0, -0.5];
        Collider { collision_groups: group, velocity, ..Collider::new(shape, [0.5, -0.4, 0.2]) }
    };
    all.colliders = vec![ball(1), ball(2), ball(4)];
    let with = |fused| Options { substeps: Some(20), ..options(fused) };
    let mut run = Run::new(&all, &with(true), &device);
    // Each has a dispatch of its own, and meets another number of colliders than the one before.
    let cloth = |n: u32| {
        let mut cloth = support::curtain(5);
        // Powers of two change no bit of its motion; cloths of one kind would share dispatches.
        cloth.set_total_mass(cloth.total_mass() * 2f64.powi(n as i32 / 3 - 17)).unwrap();
        cloth.collision_groups = [1, 3, 7][n as usize % 3];
        cloth
    };
    (0..100).for_each(|n| _ = run.stepper.add_cloth(cloth(n)).unwrap());
    assert_eq!(run.stepper.plan().dispatches(), 101);
    let run = run.whole_frames(4);
    // Without inverse masses.
    let places = |run: &Run, cloth: usize| run.bits(cloth)[0].iter().map(|p| [p[0], p[1], p[2]]).collect::<Vec<_>>();
    let alone = [0, 1, 2].map(|n| {
        let scene = Scene { cloths: vec![cloth(n)], ..all.clone() };
        places(&Run::new(&scene, &with(false), &device).whole_frames(4), 0)
    });
    assert!(alone[0] != alone[1] && alone[1] != alone[2], "the other colliders matter");
    let wrong: Vec<u32> = (0..100).filter(|n| places(&run, 1 + *n as usize) != alone[(n % 3) as usize]).collect();
    assert_eq!(wrong, [0; 0]);
}

#[test]
fn a_fault_is_taken_back_in_its_own_cloth() {
    let Some(device) = roomy() else { return };
    let mut two = scene::builtin("s1", 17).unwrap();
    two.cloths.push(two.cloths[0].clone());
    let with = |fused| Options { tethers: 0, ..options(fused) };
    let run = |fused| {
        let mut run = Run::new(&two, &with(fused), &device).frames(5);
        let good = run.bits(0)[0].clone();
        let mut matrix = [[0.0; 4]; 4];
        (matrix[0][0], matrix[1][1], matrix[2][2], matrix[3][3]) = (3e38, 3e38, 3e38, 1.0);
        run.stepper.transform(0, &[40], matrix).unwrap();
        let run = run.frames(1);
        assert!(run.bits(0)[0] == good);
        let faults = |c| {
            let span = run.stepper.buffers(c).unwrap().faults.clone().unwrap();
            read_back_u32(&device.0, &device.1, &span).unwrap()
        };
        let (hit, other) = (faults(0), faults(1));
        assert!(hit[0] > 0 && hit[1] == 1 && hit[2] > 0, "{hit:?}");
        assert_eq!(other[..3], [0, 0, 0]);
        (hit[..3].to_vec(), run.bits(1))
    };
    assert!(run(true) == run(false));
}

#[test]
fn calm_cloth_falls_asleep_out_of_a_batch() {
    let Some(device) = roomy() else { return };
    let mut two = scene::builtin("s1", 9).unwrap();
    two.gravity = [0.0; 3];
    two.cloths.push(two.cloths[0].clone());
    (two.cloths[1].velocity, two.cloths[1].damping) = ([0.0, 2.0, 0.0], 0.0);
    let with = |fused| Options { sleep: Some(Sleep { speed: 0.01, after: 0.1 }), ..options(fused) };
    for fused in [true, false] {
        let run = Run::new(&two, &with(fused), &device).whole_frames(30);
        let asleep = [0, 1].map(|c| run.stepper.is_asleep(c));
        assert_eq!(asleep, [true, false], "{fused}");
        assert_eq!(run.stepper.plan().passes.iter().filter(|p| p.cloth == 0).count(), 0);
    }
}

/// Colliders in a lattice through and around the cloth, near ones among far ones, in motion.
fn crowd(count: u32) -> Vec<Collider> {
    let place = |k: u32| [k % 5, k / 5 % 5, k / 25].map(|c| 0.45 * c as f32 - 0.7);
    let q = [0.2f32, -0.5, 0.3, 0.7];
    let norm = q.iter().map(|x| x * x).sum::<f32>().sqrt();
    let one = |k: u32| {
        let radii = [0.1, 0.06, 0.08];
        let shape = match k % 5 {
            0 => Shape::Sphere { radius: 0.09 },
            1 => Shape::Capsule { half_height: 0.07, radius: 0.04 },
            2 => Shape::Box { half: [0.05, 0.08, 0.06] },
            3 => Shape::Ellipsoid { radii, closest: false },
            _ => Shape::HalfSpace,
        };
        let mut center = place(k / 5 * 7 % 125);
        center[1] -= if shape == Shape::HalfSpace { 5.0 } else { 0.45 };
        let (velocity, spin) = ([0.3, 0.5, 0.1 * (k % 7) as f32], [0.0, 2.0, 1.0]);
        let rotation = if shape == Shape::HalfSpace { [0.0, 0.0, 0.0, 1.0] } else { q.map(|x| x / norm) };
        Collider { rotation, velocity, spin, friction: 0.2, ..Collider::new(shape, center) }
    };
    (0..count).map(one).collect()
}

#[test]
fn colliders_out_of_reach_change_nothing() {
    let Some(device) = roomy() else { return };
    let cloth = |n| {
        let mut cloth = Flat { origin: [-0.3, 0.0, -0.2], ..Flat::square("flat", n) }.cloth().unwrap();
        cloth.velocity = [0.0, -4.0, 0.5];
        scene(cloth)
    };
    let far = |n: u32| {
        let at = |k: u32| [30.0 + k as f32, -4.0, if k.is_multiple_of(2) { 2.0 } else { -9.0 }];
        (0..n).map(move |k| Collider::new(Shape::Sphere { radius: 0.4 }, at(k)))
    };
    let near = || vec![Collider { friction: 0.3, ..Collider::new(Shape::Sphere { radius: 0.3 }, [0.2, -0.4, 0.2]) }];
    // One workgroup, and one for 64 particles each; more colliders than are told apart.
    for (fused, n, more) in [(true, 24, 100), (false, 24, 100), (true, 12, 1100)] {
        let run = |colliders: Vec<Collider>| {
            let scene = Scene { colliders, ..cloth(n) };
            Run::new(&scene, &options(fused), &device).frames(8).bits(0)
        };
        let alone = run(near());
        let last = [far(more).collect::<Vec<_>>(), near()].concat();
        let first = [near(), far(more).collect()].concat();
        assert!(alone == run(last) && alone == run(first), "{fused} {n} {more}");
    }
}

#[test]
fn a_crowd_of_colliders_acts_as_on_the_twin_and_repeats() {
    let Some(device) = roomy() else { return };
    let mut flat = scene(Flat { origin: [-0.3, 0.1, -0.2], ..Flat::square("flat", 28) }.cloth().unwrap());
    flat.cloths[0].velocity = [0.0, -3.0, 0.5];
    flat.colliders = crowd(200);
    for fused in [true, false] {
        let once = Options { substeps: Some(1), step: FRAME / 4.0, max_catch_up: 1, ..options(fused) };
        let there = Run::new(&flat, &once, &device).frames(1).bits(0)[0].clone();
        let here = Options { backend: Backend::Cpu, ..once };
        let mut here = Stepper::new(flat.clone(), here, None).unwrap();
        here.advance(FRAME).unwrap();
        let apart = there.iter().zip(here.positions(0).unwrap());
        let apart = apart.flat_map(|(a, b)| (0..3).map(|c| (f32::from_bits(a[c]) - b[c]).abs())).fold(0.0, f32::max);
        assert!(apart <= rounding(&device, 1e-6), "{fused}: {apart:e} m");
        let run = || Run::new(&flat, &options(fused), &device).frames(20).bits(0);
        assert!(run() == run());
    }
    let [one, apart] = [true, false].map(|fused| Run::new(&flat, &options(fused), &device).frames(20).bits(0));
    assert!(one == apart);
}

#[test]
fn a_frame_that_is_never_submitted_costs_its_own_steps_alone() {
    let Some(device) = roomy() else { return };
    let run = |dropped: &[u32]| {
        let mut run = Run::new(&wardrobe(), &options(true), &device);
        for frame in 0..6 {
            if dropped.contains(&frame) {
                // As a host does that has no surface to draw to.
                let mut encoder = device.0.create_command_encoder(&Default::default());
                run.stepper.record(&mut encoder, FRAME).unwrap();
            }
            run = run.frames(1);
        }
        (0..wardrobe().cloths.len()).map(|c| run.bits(c)).collect::<Vec<_>>()
    };
    assert!(run(&[]) == run(&[0, 3]));
}
