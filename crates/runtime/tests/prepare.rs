//! Pipelines that are compiled before a game needs them.

// Also, or only, on the GPU.
#![cfg(feature = "gpu")]

mod support;

use gimage_runtime::*;
use support::rig::Rig;
use support::{curtain, hung_tube, made_of, two_charts};

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
    let preparation = |rig: &Rig, scene| rig.stepper.prepare(&scene, &options(), &Ahead::ALL).unwrap();
    let calm = preparation(&rig, wardrobe());
    let left = calm.left();
    assert!(left > 20, "{left}");
    // In the background, while frames are recorded.
    let worker = std::thread::spawn(move || calm.run().unwrap());
    rig.frames(3);
    assert_eq!(rig.stepper.compiled(), Some(fresh), "the frames of its own scene need nothing more");
    let made = worker.join().unwrap();
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
    let mut all = rig.stepper.prepare(&windy(), &options(), &Ahead::ALL).unwrap();
    let left = all.left();
    // One by one, as in a loading screen.
    assert_eq!((all.run_one().unwrap().pipelines, all.left()), (1, left - 1));
    ask(&mut rig);
    let asked = rig.stepper.compiled().unwrap();
    assert!(asked.pipelines > fresh.pipelines + 10, "{asked:?} {fresh:?}");
    // What the frames have compiled meanwhile is left out.
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

#[test]
fn nothing_is_left_to_prepare_on_the_cpu() {
    let stepper = Stepper::on_cpu(wardrobe(), options()).unwrap();
    let mut none = stepper.prepare(&windy(), &options(), &Ahead::ALL).unwrap();
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
