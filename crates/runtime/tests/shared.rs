//! Cloths that are too large for a workgroup share their dispatches, and move as each would alone.

use crate::support::rig::FRAME;
use crate::support::run::{Device, Run};
use crate::support::{self, curtain, scene, two_charts};
use gimage_runtime::*;

fn options(fused: bool) -> Options {
    Options { solver: Solver::Xpbd, backend: Backend::Gpu, substeps: Some(8), fused, ..Options::default() }
}

fn capsules() -> Vec<Collider> {
    let shape = Shape::Capsule { radius: 0.1, half_height: 0.2 };
    (0..4).map(|k| Collider { friction: 0.3, ..Collider::new(shape, [0.3 * k as f32, -0.4, 0.2]) }).collect()
}

fn many(cloth: &Cloth, count: usize) -> Vec<Cloth> {
    vec![cloth.clone(); count]
}

/// A garment of some 4,000 texels.
fn garment() -> Cloth {
    two_charts(45)
}

#[test]
fn many_large_cloths_take_as_many_dispatches_as_one() {
    let Some(device) = support::device() else { return };
    assert_eq!(device.0.limits().max_storage_buffers_per_shader_stage, 8, "the default of WebGPU");
    let plan = |cloths: Vec<Cloth>, colliders: Vec<Collider>| {
        Run::new(&Scene { cloths, colliders, ..Scene::new("many") }, &options(true), &device).stepper.plan()
    };
    for count in [1, 10, 16] {
        let plan = plan(many(&curtain(128), count), Vec::new());
        // Eight steps, and three passes that end the frame.
        assert_eq!(plan.dispatches(), 11, "{count} cloths: {plan}");
        let tiles = plan.passes.iter().filter(|p| matches!(&p.form, Form::Tile(t) if t.shared)).count();
        assert_eq!(tiles, count, "all in tiles: {plan}");
    }
    for count in [1, 100] {
        let plan = plan(many(&garment(), count), capsules());
        // Eight steps, the seams and the contact of the last one, and three passes that end the frame.
        assert_eq!(plan.dispatches(), 12, "{count} garments: {plan}");
    }
}

#[test]
fn many_cloths_with_a_pyramid_take_as_many_dispatches_as_one() {
    let Some(device) = support::device() else { return };
    let plan = |cloth: &Cloth, count: usize| {
        let with = Options { pyramid: 4, tethers: 0, ..options(true) };
        let all = Scene { cloths: many(cloth, count), ..Scene::new("many") };
        Run::new(&all, &with, &device).stepper.plan()
    };
    for count in [1, 10, 100] {
        let whole = plan(&curtain(32), count);
        assert_eq!(whole.dispatches(), 1, "{count} cloths: {whole}");
        // Two steps of eight have the step alone, a dispatch for the levels, one for the finest of 33 x 33 nodes, and one for the
        // particles that follow, before their springs.
        let levels = plan(&curtain(64), count);
        assert_eq!(levels.dispatches(), 6 + 2 * 5 + 3, "{count} cloths: {levels}");
        // Two more where there are seams: ties behind that level, and particles at the seam; normals at seams end the frame.
        let sewn = plan(&garment(), count);
        assert_eq!(sewn.dispatches(), 6 + 2 * 7 + 4, "{count} garments: {sewn}");
    }
}

#[test]
fn instances_of_a_large_garment_share_its_images() {
    let Some(device) = support::device() else { return };
    let memory = |count: usize| {
        let all = Scene { cloths: many(&garment(), count), ..Scene::new("many") };
        Run::new(&all, &Options { tethers: 2, ..options(true) }, &device).stepper.memory()
    };
    let (one, all) = (memory(1), memory(10));
    // Jobs, grids and seams are each cloth's own.
    let cloth = garment();
    let seams = 4 * (cloth.rings().0.len() + cloth.rings().1.len()) as u64;
    assert!(all.device_images <= one.device_images + 10 * (64 + 64 + seams), "{one:?}, {all:?}");
    assert!(all.device_states > 9 * one.device_states, "{one:?}, {all:?}");
}

#[test]
fn the_longest_dispatch_is_bounded_by_work() {
    let Some(device) = support::device() else { return };
    let run = |polish| {
        let all = Scene { cloths: many(&curtain(60), 80), ..Scene::new("many") };
        Run::new(&all, &Options { polish: Some(polish), ..options(true) }, &device).stepper.plan()
    };
    let batches = |plan: &Plan| {
        let first = |p: &&PlannedPass| p.dispatches > 0 && p.shader == "guard";
        plan.passes.iter().filter(first).count()
    };
    // A software adapter takes 2^24 relaxations at a time, a GPU more.
    let (few, much) = (run(0), run(64));
    assert_eq!(batches(&few), 1, "{few}");
    let software = device.0.adapter_info().device_type == wgpu::DeviceType::Cpu;
    assert!(batches(&much) > 1 || !software, "{much}");
}

#[test]
fn a_small_cloth_does_not_take_the_workgroups_of_a_large_one() {
    let Some(device) = support::device() else { return };
    let plan = |sizes: &[u32]| {
        let cloths = sizes.iter().map(|n| curtain(*n)).collect();
        Run::new(&Scene { cloths, ..Scene::new("sizes") }, &options(true), &device).stepper.plan()
    };
    assert_eq!(plan(&[40, 60, 100, 40]).dispatches(), 11, "sizes are alike");
    assert_eq!(plan(&[[300].as_slice(), &[38; 14]].concat()).dispatches(), 22, "one is far larger");
}

/// Cloths of many sizes, seamed and not, soft and not, of materials, pinned and free, each with its own damping and thickness.
fn wardrobe() -> Scene {
    let mut all = Scene { colliders: capsules(), ..Scene::new("wardrobe") };
    for n in [41, 70, 55] {
        all.cloths.extend([curtain(n), two_charts(n - 10), support::tube(n, 40, 3)]);
        all.cloths.push(support::made_of(curtain(n)));
        all.cloths.push(support::made_of(two_charts(n - 10)));
        let mut soft = curtain(n);
        soft.compliance = Compliance::Constant(1e-4);
        all.cloths.push(soft);
    }
    for (k, cloth) in all.cloths.iter_mut().enumerate() {
        cloth.damping = 0.1 * k as f32;
        cloth.velocity = [0.2, 0.0, 0.1 * k as f32];
        cloth.thickness = Some(0.002 * (k % 3) as f32);
    }
    all
}

/// Whether each cloth of a scene moves as it would alone, in passes of its own.
fn move_as_alone(all: &Scene, with: impl Fn(bool) -> Options, device: &Device) {
    let together = Run::new(all, &with(true), device);
    let plan = together.stepper.plan();
    assert!(plan.passes.iter().any(|p| matches!(&p.form, Form::Tile(t) if t.shared)), "{plan}");
    let together = together.frames(3);
    for (index, cloth) in all.cloths.iter().enumerate() {
        let alone = Scene { cloths: vec![cloth.clone()], ..all.clone() };
        let alone = Run::new(&alone, &with(false), device).frames(3);
        assert!(together.bits(index) == alone.bits(0), "cloth {index}: {plan}");
    }
}

#[test]
fn cloths_of_all_sizes_move_as_each_alone() {
    let Some(device) = support::device() else { return };
    let all = wardrobe();
    let of =
        |substeps, polish| move |fused| Options { substeps: Some(substeps), polish: Some(polish), ..options(fused) };
    move_as_alone(&all, of(5, 0), &device);
    move_as_alone(&Scene { colliders: Vec::new(), ..all.clone() }, of(4, 1), &device);
    move_as_alone(&all, |fused| Options { iterations: 2, ..of(3, 0)(fused) }, &device);
}

#[test]
fn cloths_with_a_pyramid_move_as_each_alone() {
    let Some(device) = support::device() else { return };
    let all = Scene { colliders: Vec::new(), ..wardrobe() };
    for (pyramid, iterations, tethers) in [(1, 1, 0), (2, 2, 2)] {
        let with = |fused| Options { substeps: Some(3), pyramid, iterations, tethers, ..options(fused) };
        move_as_alone(&all, with, &device);
    }
    let windy = Scene { wind: Some(support::wind(true)), ..all };
    move_as_alone(&windy, |fused| Options { substeps: Some(3), pyramid: 2, ..options(fused) }, &device);
}

#[test]
fn cloths_that_sleep_wake_and_leave_compile_nothing_and_cuts_are_prepared() {
    let Some(device) = support::device() else { return };
    let cloths = vec![two_charts(45), two_charts(30), two_charts(38), curtain(70), curtain(40)];
    let all = Scene { cloths, colliders: capsules(), ..Scene::new("all") };
    let mut run = Run::new(&all, &options(true), &device).frames(1);
    // Cloth that a host lets sleep among colliders has a box.
    run.stepper.prepare(&all, run.stepper.options(), &[Ahead::Cuts, Ahead::Bounds]).unwrap().run().unwrap();
    let compiled = |run: &Run| run.stepper.compiled().unwrap().pipelines;
    let first = compiled(&run);
    // The largest of each kind.
    for cloth in [0, 3] {
        run.stepper.set_asleep(cloth, true).unwrap();
    }
    let mut run = run.frames(1);
    run.stepper.set_asleep(0, false).unwrap();
    run.stepper.remove_cloth(3).unwrap();
    let mut run = run.frames(1);
    run.stepper.remove_cloth(0).unwrap();
    let run = run.frames(1);
    assert_eq!(compiled(&run), first, "{}", run.stepper.plan());
    let mut run = run;
    run.stepper.cut([0.5, 0.5, 3.0], [-4.0, -0.1, -2.0], [5.0, -0.1, -2.0]).unwrap();
    assert_eq!(compiled(&run.frames(2)), first);
}

/// Steps so short that rounding is kept, with multipliers summed over relaxations: a tile binds as many buffers as there may be.
#[test]
fn garments_with_all_lists_move_as_each_alone() {
    let Some(device) = support::device() else { return };
    let mut all = Scene { colliders: capsules(), wind: Some(support::wind(false)), ..Scene::new("full") };
    for n in [40, 36] {
        let mut soft = two_charts(n);
        soft.compliance = Compliance::Constant(1e-4);
        soft.limits = Some(vec![0.3; soft.len()].into());
        all.cloths.extend([soft, support::tube(n, 40, 3), support::made_of(two_charts(n))]);
    }
    for (iterations, polish) in [(2, 1), (1, 0)] {
        let with = |fused| Options { substeps: Some(24), iterations, polish: Some(polish), ..options(fused) };
        let run = Run::new(&all, &with(true), &device);
        let bound = |p: &PlannedPass| p.bindings.iter().filter(|b| !["frame", "batch", "part"].contains(&b.0)).count();
        let most = run.stepper.plan().passes.iter().map(bound).max();
        assert!(most <= Some(8), "{}", run.stepper.plan());
        move_as_alone(&all, with, &device);
    }
}

#[test]
fn wind_acts_on_light_and_heavy_cloths_at_different_times() {
    let Some(device) = support::device() else { return };
    let sheet = |(n, mass)| {
        let mut cloth = Flat { mass, ..Flat::square("sheet", n) }.cloth().unwrap();
        cloth.set_pinned(0, true).unwrap();
        cloth
    };
    let cloths: Vec<_> = [(50, 0.2), (60, 0.02), (45, 0.1)].map(sheet).into();
    for triangles in [false, true] {
        let all = Scene { cloths: cloths.clone(), wind: Some(support::wind(triangles)), ..Scene::new("windy") };
        move_as_alone(&all, |fused| Options { substeps: Some(32), ..options(fused) }, &device);
    }
}

#[test]
fn others_go_on_as_cloths_sleep_are_cut_leave_and_come() {
    let Some(device) = support::device() else { return };
    let mut all = scene(curtain(50));
    all.cloths.extend([two_charts(40), curtain(70), two_charts(45), curtain(45), curtain(60)]);
    for (k, cloth) in all.cloths.iter_mut().enumerate() {
        cloth.velocity = [0.1 * k as f32, 0.0, 0.3];
    }
    all.colliders = capsules();
    let run = |fused| {
        let mut run = Run::new(&all, &Options { substeps: Some(3), ..options(fused) }, &device).frames(3);
        run.stepper.set_asleep(2, true).unwrap();
        let mut run = run.frames(2);
        run.stepper.set_pinned(3, 77, true).unwrap();
        run.stepper.set_position(3, 77, [0.3, -0.2, 0.1]).unwrap();
        run.stepper.set_asleep(2, false).unwrap();
        run.stepper.set_asleep(0, true).unwrap();
        let mut run = run.frames(2);
        run.stepper.remove_cloth(4).unwrap();
        let mut run = run.frames(2);
        run.stepper.add_cloth(curtain(65)).unwrap();
        run.stepper.set_asleep(0, false).unwrap();
        let mut run = run.frames(2);
        run.stepper.cut([0.5, 0.5, 3.0], [-4.0, -0.1, -2.0], [5.0, -0.1, -2.0]).unwrap();
        let run = run.frames(2);
        ((0..run.stepper.scene().cloths.len()).map(|c| run.bits(c)).collect::<Vec<_>>(), run.stepper.plan())
    };
    let ((shared, plan), (apart, _)) = (run(true), run(false));
    for (cloth, (a, b)) in shared.iter().zip(&apart).enumerate() {
        assert!(a == b, "cloth {cloth}: {plan}");
    }
}

#[test]
fn a_frame_without_a_step_and_faults_are_the_same_for_all() {
    let Some(device) = support::device() else { return };
    let mut all = scene(two_charts(40));
    all.cloths.extend([two_charts(45), two_charts(38)]);
    all.cloths[1].velocity = [0.1, 0.0, 0.8];
    all.colliders = capsules();
    let run = |fused| {
        let mut run = Run::new(&all, &Options { tethers: 0, ..options(fused) }, &device).frames(3);
        let record = |stepper: &mut Stepper, dt: f64| {
            let mut encoder = device.0.create_command_encoder(&Default::default());
            let steps = stepper.record(&mut encoder, dt).unwrap().steps;
            device.1.submit([encoder.finish()]);
            steps
        };
        run.stepper.set_position(1, 0, [0.01, 0.2, 0.05]).unwrap();
        assert_eq!(record(&mut run.stepper, 0.0), 0);
        let moved: Vec<_> = (0..3).map(|c| run.bits(c)).collect();
        let mut matrix = [[0.0; 4]; 4];
        (matrix[0][0], matrix[1][1], matrix[2][2], matrix[3][3]) = (3e38, 3e38, 3e38, 1.0);
        run.stepper.transform(1, &[1500], matrix).unwrap();
        assert!(record(&mut run.stepper, FRAME) > 0);
        let faults = |run: &Run| {
            let of = |c| read_back_u32(&device.0, &device.1, run.stepper.buffers(c).unwrap().faults.as_ref().unwrap());
            (0..3).map(|c| of(c).unwrap()[..3].to_vec()).collect::<Vec<_>>()
        };
        let there = faults(&run);
        assert!(there[1][0] > 0 && there[1][1] == 1 && there[0][..2] == [0, 0], "{there:?}");
        let run = run.frames(2);
        let after = faults(&run);
        assert!(after.iter().all(|f| f[0] == 0) && after[1][1] == 1, "{after:?}");
        // Which particles others have drawn along may depend on the form.
        let taken = there.iter().map(|f| f[1]).collect::<Vec<_>>();
        (moved, taken, (0..3).map(|c| run.bits(c)).collect::<Vec<_>>())
    };
    assert!(run(true) == run(false));
}

/// A software adapter ends all loops of a thread after a number of iterations.
#[test]
fn loops_over_many_colliders_have_a_dispatch_of_their_own() {
    let Some(device) = support::device() else { return };
    let ball = |k: usize| {
        let at = [0.05 * (k % 30) as f32, -0.05 * (k / 30) as f32, 0.12];
        Collider { friction: 0.2, ..Collider::new(Shape::Sphere { radius: 0.03 }, at) }
    };
    for count in [20, 600] {
        let mut all = scene(two_charts(40));
        all.cloths.push(two_charts(36));
        all.cloths.iter_mut().for_each(|cloth| cloth.velocity = [0.0, 0.0, 2.0]);
        all.colliders = (0..count).map(ball).collect();
        let [shared, apart] = [true, false].map(|fused| Run::new(&all, &options(fused), &device));
        let contact = |p: &&PlannedPass| matches!(p.form, Form::Together(Pass::Contact(_)));
        let alone = shared.stepper.plan().passes.iter().filter(contact).count();
        let software = device.0.adapter_info().device_type == wgpu::DeviceType::Cpu;
        assert_eq!(alone > 0, software && count > 100, "{}", shared.stepper.plan());
        let [shared, apart] = [shared, apart].map(|run| run.frames(3));
        assert!((0..2).all(|c| shared.bits(c) == apart.bits(c)), "{count} colliders");
    }
}
