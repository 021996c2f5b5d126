//! Pipelines that are compiled before a game needs them.

use crate::support::rig::Rig;
use crate::support::{self, curtain, hung_tube, made_of, two_charts};
use gimage_runtime::*;

fn options() -> Options {
    Options { substeps: Some(3), sleep: Some(Sleep { speed: 0.05, after: 0.1 }), ..Options::default() }
}

/// Cloths that run as whole frames and by tiles, with seams and without, one of a material, over a ball.
fn wardrobe() -> Scene {
    let mut scene = support::scene(curtain(14));
    scene.cloths.extend([hung_tube(3), two_charts(9), made_of(curtain(9)), curtain(70)]);
    let ball = Collider::new(Shape::Sphere { radius: 0.2 }, [0.5, -0.4, 0.4]);
    scene.colliders.push(Collider { friction: 0.4, ..ball });
    scene
}

/// The same in wind on triangles.
fn windy() -> Scene {
    Scene { wind: Some(support::wind(true)), ..wardrobe() }
}

/// Everything that a game may ask, and the frames after it.
fn ask(rig: &mut Rig) {
    let (device, queue) = rig.device().cloned().unwrap();
    rig.frames(2);
    rig.pick([0.5, 4.0, 0.1], [0.0, -1.0, 0.02]);
    rig.stepper.set_pins(0, &[0], &[[0.0, 0.1, 0.0]]).unwrap();
    let still = [[1.0, 0.0, 0.0, 0.0], [0.0, 1.0, 0.0, 0.0], [0.0, 0.0, 1.0, 0.0], [0.0, 0.0, 0.0, 1.0]];
    rig.stepper.transform(2, &[3, 4, 5], still).unwrap();
    for open in [false, true] {
        let mut encoder = device.create_command_encoder(&Default::default());
        for cloth in 0..rig.stepper.scene().cloths.len() {
            rig.stepper.index_buffer(cloth).unwrap();
        }
        rig.stepper.record_bounds(&mut encoder).unwrap();
        rig.stepper.record_tangents(&mut encoder, 0).unwrap();
        queue.submit([encoder.finish()]);
        rig.frames(2);
        if !open {
            rig.stepper.cut([0.6, -0.45, 3.0], [0.3, -0.45, -2.0], [5.0, -0.45, -2.0]).unwrap();
            rig.frames(2);
        }
    }
    rig.pick([0.5, 4.0, 0.1], [0.0, -1.0, 0.02]);
    rig.stepper.set_wind(Some(support::wind(true))).unwrap();
    rig.frames(2);
}

#[test]
fn nothing_is_compiled_in_a_game_that_was_prepared() {
    let Some(device) = support::device_with(device_limits) else { return };
    let mut rig = Rig::gpu(wardrobe(), &options(), &device);
    let fresh = rig.stepper.compiled().unwrap();
    let preparation = |rig: &Rig, scene| rig.stepper.prepare(&scene, &options(), Ahead::ALL).unwrap();
    let calm = preparation(&rig, wardrobe());
    let left = calm.left();
    assert!(left > 20, "{left}");
    // In the background, while frames are recorded.
    let worker = std::thread::spawn(move || calm.run().unwrap());
    // wgpu lets no other thread wait for OpenGL longer than a second.
    let alone = device.0.adapter_info().backend == wgpu::Backend::Gl;
    let early = (!alone).then(|| rig.frames(3));
    let made = worker.join().unwrap();
    early.unwrap_or_else(|| rig.frames(3));
    assert_eq!(rig.stepper.compiled(), Some(fresh), "the frames of its own scene need nothing more");
    assert_eq!(made.pipelines as usize, left);
    assert!(made.ms > 0.0);
    let windy = preparation(&rig, windy());
    assert!((1..left).contains(&windy.left()), "{}", windy.left());
    windy.run().unwrap();
    assert_eq!([wardrobe(), self::windy()].map(|scene| preparation(&rig, scene).left()), [0; 2]);

    ask(&mut rig);
    assert_eq!(rig.stepper.compiled(), Some(fresh), "what was prepared is not compiled again");
}

#[test]
fn what_was_not_prepared_is_compiled_when_it_is_needed() {
    let Some(device) = support::device_with(device_limits) else { return };
    let mut rig = Rig::gpu(wardrobe(), &options(), &device);
    let fresh = rig.stepper.compiled().unwrap();
    let mut all = rig.stepper.prepare(&windy(), &options(), Ahead::ALL).unwrap();
    let left = all.left();
    // One by one, as in a loading screen.
    assert_eq!((all.run_one().unwrap().pipelines, all.left()), (1, left - 1));
    ask(&mut rig);
    let asked = rig.stepper.compiled().unwrap();
    assert!(asked.pipelines > fresh.pipelines + 10, "{asked:?} {fresh:?}");
    // Pipelines that the frames have compiled meanwhile are left out.
    assert!((all.run().unwrap().pipelines as usize) < left - 10);
}

#[test]
fn a_cloth_that_was_prepared_joins_without_a_compilation() {
    let Some(device) = support::device_with(device_limits) else { return };
    let mut rig = Rig::gpu(support::scene(curtain(14)), &options(), &device);
    let mut later = rig.stepper.scene().clone();
    later.cloths.push(hung_tube(3));
    let made = rig.stepper.prepare(&later, rig.stepper.options(), &[]).unwrap().run().unwrap();
    assert!(made.pipelines > 0, "a cloth with seams is another kind");
    let before = rig.stepper.compiled();
    rig.stepper.add_cloth(hung_tube(3)).unwrap();
    rig.frames(2);
    assert_eq!(rig.stepper.compiled(), before);
}

/// Runs the preparation of the scene as it is now for some calls, and checks that they, and two frames after them, compile nothing more.
#[track_caller]
fn prepared(scene: Scene, options: &Options, ahead: &[Ahead], before: fn(&mut Rig), call: fn(&mut Rig)) {
    let Some(device) = support::device_with(device_limits) else { return };
    let mut rig = Rig::gpu(scene, options, &device);
    before(&mut rig);
    let asked = rig.stepper.prepare(rig.stepper.scene(), rig.stepper.options(), ahead).unwrap();
    let left = asked.left();
    asked.run().unwrap();
    let compiled = rig.stepper.compiled();
    call(&mut rig);
    rig.frames(2);
    assert_eq!(rig.stepper.compiled(), compiled, "{left} were prepared");
}

/// A curtain over a ball, with the numbers that are chosen.
fn hung() -> Scene {
    Scene { cloths: vec![curtain(14)], ..wardrobe() }
}

#[test]
fn the_frames_after_the_last_pin_is_freed_are_prepared_with_pins() {
    let call = |rig: &mut Rig| {
        let of = &rig.stepper.scene().cloths[0];
        let pins: Vec<u32> = (0..of.len() as u32).filter(|k| of.particles()[*k as usize].is_pinned()).collect();
        let before = rig.stepper.polish();
        rig.stepper.unpin(0, &pins).unwrap();
        assert_ne!(rig.stepper.polish(), before, "other rounds are chosen");
    };
    prepared(hung(), &Options::default(), &[Ahead::Pins], |_| {}, call);
}

#[test]
fn the_frames_after_some_cloths_are_freed_are_prepared_with_pins() {
    let mut scene = scene::builtin("s1", 14).unwrap();
    scene.cloths = vec![scene.cloths[0].clone(); 3];
    // Two that whip about, and one that does not.
    [0.1, 0.1, 1.0].into_iter().zip(&mut scene.cloths).for_each(|(damping, cloth)| cloth.damping = damping);
    let call = |rig: &mut Rig| {
        let before = rig.stepper.polish();
        for cloth in 0..2 {
            let of = &rig.stepper.scene().cloths[cloth];
            let pins: Vec<u32> = (0..of.len() as u32).filter(|k| of.particles()[*k as usize].is_pinned()).collect();
            rig.stepper.unpin(cloth, &pins).unwrap();
        }
        let after = rig.stepper.polish();
        assert!(0 < after && after < before, "{before} {after}");
    };
    prepared(scene, &Options::default(), &[Ahead::Pins], |_| {}, call);
}

#[test]
fn frames_too_long_for_one_dispatch_compile_nothing_more() {
    let options = Options { substeps: Some(160), iterations: 60, ..Options::default() };
    let call = |rig: &mut Rig| {
        assert!(rig.stepper.plan().dispatches() > 1, "{}", rig.stepper.plan());
        rig.frame(0.05);
    };
    prepared(hung(), &options, &[], |_| {}, call);
}

#[test]
fn cloths_keep_their_tethers_and_their_precision_in_a_preparation() {
    // Tethers stay where the pins were that they were made for; positions are exact in short steps only if the first were short.
    let before = |rig: &mut Rig| {
        rig.stepper.unpin(0, &[0]).unwrap();
        rig.stepper.pin(0, &[100]).unwrap();
        let shorter = Options { substeps: Some(40), ..rig.stepper.options().clone() };
        rig.stepper.set_options(shorter).unwrap();
        rig.frames(1);
    };
    let call = |rig: &mut Rig| rig.stepper.set_wind(Some(support::wind(true))).unwrap();
    let Some(device) = support::device_with(device_limits) else { return };
    let options = Options { substeps: Some(4), ..Options::default() };
    let mut rig = Rig::gpu(hung(), &options, &device);
    before(&mut rig);
    let mut later = rig.stepper.scene().clone();
    later.wind = Some(support::wind(true));
    rig.stepper.prepare(&later, rig.stepper.options(), &[]).unwrap().run().unwrap();
    let compiled = rig.stepper.compiled();
    call(&mut rig);
    rig.frames(2);
    assert_eq!(rig.stepper.compiled(), compiled);
}

#[test]
fn states_of_cloth_that_is_asleep_are_prepared() {
    let call = |rig: &mut Rig| {
        rig.stepper.set_asleep(0, true).unwrap();
        let state = rig.stepper.state(0).unwrap();
        rig.stepper.set_state(0, &state).unwrap();
        assert!(rig.stepper.is_asleep(0));
    };
    let scene = Scene { colliders: Vec::new(), ..hung() };
    prepared(scene, &Options::default(), &[Ahead::States], |_| {}, call);
}

#[test]
fn cloth_that_is_cut_already_is_prepared_as_such() {
    let before = |rig: &mut Rig| {
        rig.stepper.cut([0.6, -0.45, 3.0], [0.3, -0.45, -2.0], [5.0, -0.45, -2.0]).unwrap();
        rig.frames(1);
    };
    let call = |rig: &mut Rig| _ = rig.pick([0.5, 4.0, 0.1], [0.0, -1.0, 0.02]);
    prepared(hung(), &Options::default(), &[Ahead::Picks], before, call);
}

#[test]
fn many_large_cloths_that_come_are_prepared_as_each_runs() {
    let Some(device) = support::device_with(device_limits) else { return };
    // Sixteen of them at the start would share a dispatch.
    let mut rig = Rig::gpu(support::scene(curtain(14)), &Options::default(), &device);
    let mut later = rig.stepper.scene().clone();
    later.cloths.extend((0..16).map(|_| curtain(70)));
    rig.stepper.prepare(&later, rig.stepper.options(), &[]).unwrap().run().unwrap();
    let compiled = rig.stepper.compiled();
    rig.stepper.add_cloth(curtain(70)).unwrap();
    rig.frames(2);
    assert_eq!(rig.stepper.compiled(), compiled);
}

#[test]
fn a_preparation_on_a_lost_device_says_so_and_keeps_what_is_left() {
    let Some(device) = support::device_with(device_limits) else { return };
    let rig = Rig::gpu(wardrobe(), &options(), &device);
    let mut all = rig.stepper.prepare(&windy(), &options(), Ahead::ALL).unwrap();
    let left = all.left();
    device.0.destroy();
    _ = device.0.poll(wgpu::PollType::wait_indefinitely());
    assert!(matches!(all.run_one(), Err(Error::DeviceLost)));
    assert_eq!(all.left(), left);
}

#[test]
fn nothing_is_left_to_prepare_on_the_cpu() {
    let stepper = Stepper::on_cpu(wardrobe(), options()).unwrap();
    let mut none = stepper.prepare(&windy(), &options(), Ahead::ALL).unwrap();
    assert_eq!((none.left(), none.run_one().unwrap()), (0, Compiled::default()));
}

#[test]
fn a_scene_that_is_refused_is_not_prepared() {
    let Some(device) = support::device() else { return };
    let rig = Rig::gpu(wardrobe(), &options(), &device);
    let mut wrong = wardrobe();
    wrong.cloths[0].damping = f32::NAN;
    assert!(rig.stepper.prepare(&wrong, &options(), &[]).is_err());
}

/// Whether it saves time is a matter of the driver: lavapipe keeps nothing there.
#[test]
#[expect(unsafe_code, reason = "wgpu cannot check the bytes of a cache; these come from it")]
fn a_cache_of_the_host_changes_no_result() {
    let Some(adapter) = support::adapter::any() else { return };
    if !adapter.features().contains(wgpu::Features::PIPELINE_CACHE) {
        support::lacking::<()>("a pipeline cache");
        return;
    }
    let required_features = wgpu::Features::PIPELINE_CACHE;
    let wanted =
        wgpu::DeviceDescriptor { required_features, required_limits: device_limits(&adapter), ..Default::default() };
    let (device, queue) = pollster::block_on(adapter.request_device(&wanted)).unwrap();
    let cache = |data: Option<&[u8]>| {
        let of = wgpu::PipelineCacheDescriptor { label: None, data, fallback: true };
        unsafe { device.create_pipeline_cache(&of) }
    };
    let positions = |cache: Option<&wgpu::PipelineCache>| {
        let gpu = (&device, &queue);
        let mut stepper = match cache {
            Some(cache) => Stepper::with_cache(wardrobe(), options(), gpu, cache),
            None => Stepper::new(wardrobe(), options(), Some(gpu)),
        }
        .unwrap();
        let mut encoder = device.create_command_encoder(&Default::default());
        stepper.record(&mut encoder, 1.0 / 60.0).unwrap();
        queue.submit([encoder.finish()]);
        read_back(&device, &queue, &stepper.buffers(0).unwrap().now).unwrap()
    };
    let empty = cache(None);
    let first = positions(Some(&empty));
    let kept = empty.get_data().expect("the bytes of the cache");
    assert_eq!(positions(Some(&cache(Some(&kept)))), first);
    assert_eq!(positions(None), first);
}
