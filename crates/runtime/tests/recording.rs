//! Recording a frame makes no allocation beside those that wgpu makes for the same commands, whatever the number of cloths.

use crate::support::run::Device;
use crate::support::{self, device_with, scene};
use allocation_counter::measure;
use gimage_runtime::scene::Pose;
use gimage_runtime::*;

fn options() -> Options {
    Options { backend: Backend::Gpu, substeps: Some(8), ..Options::default() }
}

/// Cloths of two kinds among capsules.
fn crowd(count: usize) -> Scene {
    let mut all = scene(support::curtain(12));
    let more = (1..count).map(|k| if k % 2 == 0 { support::curtain(12) } else { support::two_charts(9) });
    all.cloths.extend(more);
    let shape = Shape::Capsule { radius: 0.1, half_height: 0.2 };
    all.colliders = (0..8).map(|k| Collider::new(shape, [0.3 * k as f32, -0.4, 0.3])).collect();
    all
}

/// Allocations of recording a frame, `before` being done before it, in each of three frames after the first five. Without those of a
/// call in which no step is due, which asks the device whether it is lost, and for its errors.
fn allocations(stepper: &mut Stepper, (device, queue): &Device, before: impl Fn(&mut Stepper, u32)) -> [u64; 3] {
    let mut counts = [0; 3];
    for frame in 0..8 {
        let mut encoder = device.create_command_encoder(&Default::default());
        let count = measure(|| {
            before(stepper, frame);
            assert!(stepper.record(&mut encoder, 1.0 / 60.0).is_ok());
        });
        let idle = measure(|| assert!(stepper.record(&mut encoder, 0.0).is_ok_and(|progress| progress.steps == 0)));
        queue.submit([encoder.finish()]);
        // Measurements under way arrive before the next frame.
        assert!(stepper.settle().is_ok() && device.poll(wgpu::PollType::wait_indefinitely()).is_ok());
        assert!(stepper.settle().is_ok());
        if frame >= 5 {
            counts[frame as usize - 5] = count.count_total - idle.count_total;
        }
    }
    counts
}

/// Those of wgpu: a number of copies, and a compute pass with a list of dispatches, each a pipeline by number, and whether it has dynamic
/// offsets, two of them.
fn bare((device, queue): &Device, copies: usize, dispatches: &[(usize, bool)]) -> u64 {
    let module = device.create_shader_module(wgpu::ShaderModuleDescriptor {
        label: None,
        source: wgpu::ShaderSource::Wgsl(
            "@group(0) @binding(0) var<uniform> x: vec4<u32>;\n\
             @group(0) @binding(1) var<storage, read_write> y: array<vec4<u32>>;\n\
             @compute @workgroup_size(1) fn main() { y[0] = x; }"
                .into(),
        ),
    });
    let buffer = |usage| {
        device.create_buffer(&wgpu::BufferDescriptor { label: None, size: 16, usage, mapped_at_creation: false })
    };
    let (x, y) = (buffer(wgpu::BufferUsages::UNIFORM), buffer(wgpu::BufferUsages::STORAGE));
    let entry = |binding, ty, has_dynamic_offset| wgpu::BindGroupLayoutEntry {
        binding,
        visibility: wgpu::ShaderStages::COMPUTE,
        ty: wgpu::BindingType::Buffer { ty, has_dynamic_offset, min_binding_size: None },
        count: None,
    };
    let make = |offset| {
        let storage = wgpu::BufferBindingType::Storage { read_only: false };
        let uniform = wgpu::BufferBindingType::Uniform;
        let entries = [entry(0, uniform, offset), entry(1, storage, false), entry(2, uniform, offset)];
        let layout =
            device.create_bind_group_layout(&wgpu::BindGroupLayoutDescriptor { label: None, entries: &entries });
        let entries = [(0, &x), (1, &y), (2, &x)]
            .map(|(binding, buffer)| wgpu::BindGroupEntry { binding, resource: buffer.as_entire_binding() });
        let group =
            device.create_bind_group(&wgpu::BindGroupDescriptor { label: None, layout: &layout, entries: &entries });
        let layout = device.create_pipeline_layout(&wgpu::PipelineLayoutDescriptor {
            label: None,
            bind_group_layouts: &[Some(&layout)],
            ..Default::default()
        });
        let pipeline = device.create_compute_pipeline(&wgpu::ComputePipelineDescriptor {
            label: None,
            layout: Some(&layout),
            module: &module,
            entry_point: Some("main"),
            compilation_options: Default::default(),
            cache: None,
        });
        (pipeline, group)
    };
    let count = dispatches.iter().map(|(pipeline, _)| pipeline + 1).max().unwrap_or(0);
    let made: Vec<_> = (0..count).map(|_| [make(false), make(true)]).collect();
    let copied = wgpu::BufferUsages::COPY_SRC | wgpu::BufferUsages::COPY_DST;
    let [a, b] = [copied; 2].map(buffer);
    let mut last = 0;
    for _ in 0..3 {
        let mut encoder = device.create_command_encoder(&Default::default());
        let count = measure(|| {
            (0..copies).for_each(|_| encoder.copy_buffer_to_buffer(&a, 0, &b, 0, 16));
            let mut pass = encoder
                .begin_compute_pass(&wgpu::ComputePassDescriptor { label: Some("cloth"), timestamp_writes: None });
            for &(n, offset) in dispatches {
                let (pipeline, group) = &made[n][usize::from(offset)];
                pass.set_pipeline(pipeline);
                pass.set_bind_group(0, group, if offset { &[0, 0] } else { &[] });
                pass.dispatch_workgroups(1, 1, 1);
            }
        });
        queue.submit([encoder.finish()]);
        last = count.count_total;
    }
    last
}

#[test]
fn frames_are_recorded_without_allocations_of_our_own() {
    let Some(device) = device_with(device_limits) else { return };
    for count in [1, 2, 100, 1000] {
        let mut stepper = Stepper::new(crowd(count), options(), Some((&device.0, &device.1))).unwrap();
        let kinds = count.min(2);
        assert_eq!(stepper.plan().dispatches(), kinds as u32);
        let dispatches: Vec<_> = (0..kinds).map(|kind| (kind, true)).collect();
        let (ours, wgpu) = (allocations(&mut stepper, &device, |_, _| ()), bare(&device, kinds, &dispatches));
        assert_eq!(ours, [wgpu; 3], "{count} cloths");
    }
}

#[test]
fn cloth_whose_rest_or_stretch_is_watched_is_recorded_without_allocations_of_our_own() {
    let Some(device) = device_with(device_limits) else { return };
    // No cloth is as calm as that, and no stretch as large.
    let sleep = Options { sleep: Some(Sleep { speed: 1e-12, after: 1e3 }), ..options() };
    let stretch = Options { substeps: None, quality: Quality::Error(0.9), ..options() };
    for (options, name) in [(sleep, "sleep"), (stretch, "stretch")] {
        for count in [1, 2, 200] {
            let mut stepper = Stepper::new(crowd(count), options.clone(), Some((&device.0, &device.1))).unwrap();
            let kinds = count.min(2);
            assert_eq!(stepper.plan().dispatches(), kinds as u32);
            let dispatches: Vec<_> = (0..kinds).map(|kind| (kind, true)).collect();
            // Speeds and stretch of a kind of cloths lie in one buffer.
            let (ours, wgpu) = (allocations(&mut stepper, &device, |_, _| ()), bare(&device, 2 * kinds, &dispatches));
            assert_eq!(ours, [wgpu; 3], "{name}, {count} cloths");
        }
    }
}

#[test]
fn tiles_are_recorded_without_allocations_of_our_own() {
    let Some(device) = device_with(device_limits) else { return };
    let mut large = scene(support::curtain(150));
    large.cloths.push(support::curtain(130));
    let mut stepper = Stepper::new(large, options(), Some((&device.0, &device.1))).unwrap();
    // One tile a step, in turn of no others, and what ends a frame.
    let mut dispatches = Vec::new();
    for (n, pass) in stepper.plan().passes.iter().enumerate() {
        let offset = pass.bindings.iter().any(|b| b.0 == "frame");
        dispatches.extend((0..pass.dispatches).map(|_| (n, offset)));
    }
    assert_eq!(dispatches[..9], [[(0, true); 8].as_slice(), &[(1, true)]].concat(), "{}", stepper.plan());
    // Jobs and grids are copied to their place.
    let (ours, wgpu) = (allocations(&mut stepper, &device, |_, _| ()), bare(&device, 1, &dispatches));
    assert_eq!(ours, [wgpu; 3]);
}

#[test]
fn allocations_for_moving_colliders_do_not_grow_with_the_cloths() {
    let Some(device) = device_with(device_limits) else { return };
    let moved = |stepper: &mut Stepper, frame: u32| {
        for collider in 0..8 {
            let to = Pose { position: [0.3 * collider as f32, -0.4, 0.3 + 0.01 * frame as f32], ..Pose::default() };
            assert!(stepper.move_collider(collider, &to).is_ok());
        }
    };
    let of = |count| {
        let mut stepper = Stepper::new(crowd(count), options(), Some((&device.0, &device.1))).unwrap();
        allocations(&mut stepper, &device, moved)
    };
    let (few, many) = (of(2).into_iter().max(), of(1000).into_iter().max());
    // wgpu's own lists grow now and then.
    assert!(many <= few.map(|few| few + 2), "{few:?} {many:?}");
}
