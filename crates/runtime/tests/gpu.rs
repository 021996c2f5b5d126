//! The GPU against its twin. Without an adapter each test says that it was skipped; GIMAGE_REQUIRE_GPU=1 makes that a
//! failure.

use std::collections::BTreeSet;
use std::sync::atomic::{AtomicBool, Ordering};
use std::task::{Context, Waker};

use crate::support::rig::Rig;
use crate::support::{self, FRAME, compared, device, scene};
use gimage_runtime::*;

const SOLVERS: [Solver; 2] = [Solver::Classic, Solver::Xpbd];

/// All scenes for the classic solver, then for XPBD, with soft springs too.
fn solved() -> Vec<(Solver, &'static str, Scene)> {
    let of =
        |solver, list: Vec<(&'static str, Scene)>| list.into_iter().map(move |(name, scene)| (solver, name, scene));
    of(Solver::Classic, compared()).chain(of(Solver::Xpbd, [support::outside(), support::soft()].concat())).collect()
}

type Lists = [Vec<[f32; 4]>; 3];

/// Colliders are where they will be at the end of a frame. The classic solver has them stand still, with a velocity.
fn carry(stepper: &mut Stepper, start: &[Collider], frame: u32) {
    if stepper.options().solver == Solver::Xpbd && !start.is_empty() {
        let time = (f64::from(frame + 1) * FRAME) as f32;
        let moved = |c: &Collider| Collider {
            center: [0, 1, 2].map(|n| c.center[n] + c.velocity[n] * time),
            spin: [0.0; 3],
            ..*c
        };
        stepper.set_colliders(start.iter().map(moved).collect()).unwrap();
    }
}

fn on_gpu(scene: Scene, options: &Options, gpu: &(wgpu::Device, wgpu::Queue), frames: u32) -> Lists {
    let (device, queue) = gpu;
    let options = Options { backend: Backend::Gpu, ..options.clone() };
    let mut stepper = Stepper::new(scene, options, Some((device, queue))).unwrap();
    let start = stepper.scene().colliders.clone();
    for frame in 0..frames {
        carry(&mut stepper, &start, frame);
        let mut encoder = device.create_command_encoder(&Default::default());
        stepper.record(&mut encoder, FRAME).unwrap();
        queue.submit([encoder.finish()]);
    }
    let buffers = stepper.buffers(0).unwrap();
    [&buffers.now, &buffers.before, &buffers.normals].map(|b| read_back(device, queue, b).unwrap())
}

fn on_cpu(scene: Scene, options: &Options, frames: u32) -> Lists {
    let options = Options { backend: Backend::Cpu, ..options.clone() };
    let mut stepper = Stepper::new(scene, options, None).unwrap();
    let start = stepper.scene().colliders.clone();
    for frame in 0..frames {
        carry(&mut stepper, &start, frame);
        stepper.advance(FRAME).unwrap();
    }
    [stepper.positions(0), stepper.previous(0), stepper.normals(0)].map(|list| list.unwrap().to_vec())
}

fn largest(a: &[[f32; 4]], b: &[[f32; 4]]) -> f32 {
    let difference = |(a, b): (&[f32; 4], &[f32; 4])| (0..3).map(|c| (a[c] - b[c]).abs()).fold(0.0, f32::max);
    a.iter().zip(b).map(difference).fold(0.0, f32::max)
}

#[test]
fn the_adapter_passes_its_self_check_once() {
    let Some((device, queue)) = support::device_with(device_limits) else { return };
    let check = self_check(&device, &queue);
    eprintln!("{}: {:.1} ms", check.adapter, check.ms);
    assert!(check.passed(), "{}", check.found());
    // The second call returns the first result, with its time.
    assert_eq!(self_check(&device, &queue), check);
    let stepper = Stepper::new(scene::builtin("s1", 9).unwrap(), Options::default(), Some((&device, &queue))).unwrap();
    assert_eq!((stepper.backend(), stepper.warnings()), (Backend::Gpu, Vec::new()));
}

/// Completes a future while another thread waits for the device, as a host does in its loop.
fn awaited<A>(device: &wgpu::Device, future: impl Future<Output = A>) -> A {
    let done = AtomicBool::new(false);
    std::thread::scope(|scope| {
        scope.spawn(|| {
            while !done.load(Ordering::Relaxed) {
                device.poll(wgpu::PollType::wait_indefinitely()).unwrap();
                std::thread::yield_now();
            }
        });
        let value = pollster::block_on(future);
        done.store(true, Ordering::Relaxed);
        value
    })
}

/// Hosts await on threads of their own.
#[test]
fn futures_and_preparations_may_go_to_another_thread() {
    fn send<T: Send>(_: &T) {}
    let Some((device, queue)) = support::device() else { return };
    let mut stepper =
        Stepper::new(scene::builtin("s2", 9).unwrap(), Options::default(), Some((&device, &queue))).unwrap();
    let mut encoder = device.create_command_encoder(&Default::default());
    let ticket = stepper.record_pick(&mut encoder, [0.1, 10.0, 0.2], [0.0, -1.0, 0.0]).unwrap();
    send(&ticket.answer(&device));
    send(&self_check_async(&device, &queue));
    send(&read_back_async(&device, &queue, &stepper.buffers(0).unwrap().now));
    send(&stepper.prepare(stepper.scene(), stepper.options(), Ahead::ALL).unwrap());
}

#[test]
fn an_asynchronous_copy_that_the_device_refuses_is_an_error() {
    let Some((device, queue)) = support::device() else { return };
    // A buffer that nothing may be copied from.
    let (usage, size) = (wgpu::BufferUsages::STORAGE, 16);
    let buffer = device.create_buffer(&wgpu::BufferDescriptor { label: None, size, usage, mapped_at_creation: false });
    let span = Span::from(buffer);
    let refused = awaited(&device, read_back_async(&device, &queue, &span));
    assert!(matches!(refused, Err(Error::Device(_))), "{refused:?}");
}

#[test]
fn what_is_awaited_is_what_waiting_returns() {
    // Other limits than in other tests: this device has not been checked.
    let fewer =
        |adapter: &wgpu::Adapter| wgpu::Limits { max_storage_buffers_per_shader_stage: 9, ..device_limits(adapter) };
    let Some((device, queue)) = support::device_with(fewer) else { return };
    let check = awaited(&device, self_check_async(&device, &queue));
    assert!(check.passed(), "{}", check.found());
    assert_eq!(self_check(&device, &queue), check, "the result is kept");
    assert_eq!(awaited(&device, self_check_async(&device, &queue)), check);

    let mut stepper =
        Stepper::new(scene::builtin("s2", 9).unwrap(), Options::default(), Some((&device, &queue))).unwrap();
    let mut encoder = device.create_command_encoder(&Default::default());
    stepper.record(&mut encoder, FRAME).unwrap();
    let ticket = stepper.record_pick(&mut encoder, [0.1, 10.0, 0.2], [0.0, -1.0, 0.0]).unwrap();
    queue.submit([encoder.finish()]);
    let buffers = stepper.buffers(0).unwrap();
    let now = awaited(&device, read_back_async(&device, &queue, &buffers.now)).unwrap();
    assert_eq!(now, read_back(&device, &queue, &buffers.now).unwrap());
    assert!(now.iter().flatten().all(|x| x.is_finite()));
    let faults = buffers.faults.as_ref().unwrap();
    let words = awaited(&device, read_back_u32_async(&device, &queue, faults)).unwrap();
    assert_eq!(words, read_back_u32(&device, &queue, faults).unwrap());
    // A future that is dropped leaves nothing behind: before it is polled, and while it waits.
    drop(ticket.answer(&device));
    let mut dropped = Box::pin(ticket.answer(&device));
    _ = dropped.as_mut().poll(&mut Context::from_waker(Waker::noop()));
    drop(dropped);
    // While one is under way, another is refused, and a refused one that is dropped ends nothing.
    let mut first = Box::pin(ticket.answer(&device));
    assert!(first.as_mut().poll(&mut Context::from_waker(Waker::noop())).is_pending());
    let second = awaited(&device, ticket.answer(&device));
    assert!(second.is_err(), "{second:?}");
    assert!(awaited(&device, first).unwrap().is_some());
    let hit = awaited(&device, ticket.answer(&device)).unwrap().unwrap();
    assert!((hit.point()[0] - 0.1).abs() < 1e-3, "{hit:?}");

    let texture = device.create_texture(&wgpu::TextureDescriptor {
        label: None,
        size: wgpu::Extent3d { width: 3, height: 2, depth_or_array_layers: 1 },
        mip_level_count: 1,
        sample_count: 1,
        dimension: wgpu::TextureDimension::D2,
        format: wgpu::TextureFormat::Rgba8Unorm,
        usage: wgpu::TextureUsages::COPY_SRC | wgpu::TextureUsages::COPY_DST,
        view_formats: &[],
    });
    let pixels: Vec<u8> = (0..24).collect();
    let layout = wgpu::TexelCopyBufferLayout { offset: 0, bytes_per_row: Some(12), rows_per_image: None };
    queue.write_texture(texture.as_image_copy(), &pixels, layout, texture.size());
    let picture = awaited(&device, read_back_picture_async(&device, &queue, &texture)).unwrap();
    assert_eq!(picture.as_flattened(), pixels);
    assert_eq!(picture, read_back_picture(&device, &queue, &texture).unwrap());
}

#[test]
fn one_step_is_that_of_the_twin() {
    let Some(gpu) = device() else { return };
    // Also what begins in contact, at rest and at speed.
    let touching = compared().into_iter().map(|(name, scene)| (Solver::Xpbd, name, scene));
    let mut fast = support::on_colliders(32);
    fast.cloths[0].velocity = [1.0, -40.0, 2.0];
    let fast = (Solver::Xpbd, "all colliders, fast", fast);
    let mut limited = scene(support::hung_tube(2));
    limited.cloths[0].limits = Some(vec![1e-3; limited.cloths[0].len()].into());
    let backstop = Backstop { distance: 1e-4, radius: 0.1 };
    limited.cloths[0].backstops = Some(vec![backstop; limited.cloths[0].len()].into());
    let limited = (Solver::Xpbd, "limits and backstops", limited);
    // Levels of a pyramid with more nodes than a workgroup, tied at a seam; and cloth that follows a joint.
    let mut large = support::tube(75, 60, 1);
    large.set_pinned(0, true).unwrap();
    let large = (Solver::Xpbd, "large tube", scene(large));
    let led = (Solver::Xpbd, "follower", scene(follower()));
    let pressed = (Solver::Xpbd, "pressed tube with contact", scene(pressed()));
    let mut seen = BTreeSet::new();
    for (solver, name, scene) in solved().into_iter().chain(touching).chain([fast, limited, large, led, pressed]) {
        let once =
            Options { substeps: Some(1), iterations: 2, step: FRAME / 8.0, max_catch_up: 1, ..Options::default() };
        let options = Options { solver, pyramid: 1, polish: Some(2), ..once };
        let plan = Stepper::on_cpu(scene.clone(), options.clone()).unwrap().plan();
        seen.extend(plan.passes.iter().filter_map(|p| p.form.pass()).map(|p| name_of(&format!("{p:?}"))));
        let there = on_gpu(scene.clone(), &options, &gpu, 1);
        let here = on_cpu(scene, &options, 1);
        let difference = largest(&there[0], &here[0]);
        eprintln!("{name}: {difference:e} m");
        let limit = support::alike::rounding(&gpu, 1e-6);
        assert!(difference <= limit, "{solver:?}, {name}: {difference:e} m");
        assert!(largest(&there[1], &here[1]) <= limit, "{name}: previous positions");
        assert!(largest(&there[2], &here[2]) <= 2e-3, "{name}: normals {:e}", largest(&there[2], &here[2]));
        assert!(there[0].iter().zip(&here[0]).all(|(a, b)| a[3] == b[3]), "{name}: inverse masses");
    }
    // All of the table, but for actions, for measures and meshes that a host reads (wrap.rs, wrap_levels.rs, wrap_cuts.rs), for cloths that meet
    // (contact.rs) and for the surface of a body (surface.rs), which have tests of their own.
    let table = include_str!("../src/passes.rs");
    let table = &table[table.find("pub enum Pass {").unwrap()..];
    let table = &table[..table.find("\n}\n").unwrap()];
    let variant = |line: &&str| line.starts_with("    ") && line[4..].starts_with(char::is_uppercase);
    let rare = ["Cut", "CutSprings", "CutTethers", "CutLevels", "Transform", "Place", "Pick", "PickNearest"];
    let carried = ["Skin", "Restrict", "Prolong", "Inertia"];
    let read = ["Speed", "Fastest", "Strain", "Bounds", "Indices", "Tangents", "Wrap", "Blend", "Jump", "WrapIndices"];
    // Of several cloths.
    let met = ["Shadow", "Extents", "Others", "Faces", "Gather", "Paths", "Truncate", "HoldBack"];
    let worn = ["SurfacePose", "SurfaceBoxes", "SurfaceSearch", "SurfaceContact"];
    let apart = [&rare[..], &read, &carried, &met, &worn].concat();
    let all = table.lines().filter(variant).map(name_of).filter(|n| !apart.contains(&&**n));
    assert_eq!(seen, all.collect());
}

/// A tube with its sides pressed together, nearer than the distance of its contact.
fn pressed() -> Cloth {
    let mut cloth = support::tube(25, 20, 1);
    let flat = cloth.positions().iter().map(|p| [p[0], p[1], 0.02 * p[2]]).collect();
    cloth.place(flat).unwrap();
    cloth.contact = Some(ClothContact::default());
    cloth
}

/// A tube whose pinned rim follows a joint.
fn follower() -> Cloth {
    let mut cloth = support::tube(17, 12, 1);
    cloth.pin(&(0..17).collect::<Vec<_>>()).unwrap();
    let one = Influence { joints: [0; 4], weights: [1.0, 0.0, 0.0, 0.0] };
    cloth.set_skin(vec![SkinJoint { name: "hips".into(), ..SkinJoint::default() }], &vec![one; cloth.len()]).unwrap();
    let still = std::array::from_fn(|k| if k % 5 == 0 { 1.0 } else { 0.0 });
    cloth.follow_joints(&[still]).unwrap();
    cloth
}

/// The name of a variant.
fn name_of(text: &str) -> String {
    text.trim().chars().take_while(char::is_ascii_alphanumeric).collect()
}

/// Starts of a cloth that differ by up to 1e-6 m; points of a seam stay together.
fn nudged(scene: &Scene, times: usize) -> impl Iterator<Item = Scene> {
    (1..=times).map(|time| {
        let mut scene = scene.clone();
        let by = |x: f32, c: usize| x + 1e-6 * (x * 997.0 * time as f32 + c as f32).sin();
        let moved = scene.cloths[0].positions().iter().map(|p| [0, 1, 2].map(|c| by(p[c], c))).collect();
        scene.cloths[0].place(moved).unwrap();
        scene
    })
}

/// Stretch, energy and the middle agree to a thousandth, or to twice what starts that differ by rounding make of them on the CPU, at most half a percent.
#[test]
fn after_100_steps_the_measures_agree() {
    let Some(gpu) = device() else { return };
    let mut apart = Vec::new();
    for (solver, name, scene) in solved() {
        let scene = if solver == Solver::Xpbd { support::smooth(scene) } else { scene };
        let options = Options { solver, substeps: Some(10), pyramid: 4, ..Options::default() };
        let cloth = &scene.cloths[0];
        let of = |lists: Lists| measure(cloth, &lists[0], &lists[1], FRAME / 10.0, scene.gravity);
        let there = of(on_gpu(scene.clone(), &options, &gpu, 10));
        let here = of(on_cpu(scene.clone(), &options, 10));
        // Energy against the sum of both kinds: where the potential is 0 is arbitrary, and they may cancel. A coordinate near 0 is
        // measured against the size of the cloth.
        let energy = here.kinetic + here.potential.abs();
        let differences = |other: &Measures| {
            let part = |a: f64, b: f64| (a - b).abs() / a.abs().max(b.abs()).max(f64::MIN_POSITIVE);
            let change = other.kinetic + other.potential - here.kinetic - here.potential;
            let middle = (0..3).map(|c| (other.center[c] - here.center[c]).abs()).fold(0.0, f64::max);
            let stretch = [part(other.stretch_max, here.stretch_max), part(other.stretch_mean, here.stretch_mean)];
            [stretch[0], stretch[1], change.abs() / energy.max(f64::MIN_POSITIVE), middle]
        };
        let found = differences(&there);
        if found.iter().all(|part| *part <= 1e-3) {
            continue;
        }
        let chance = nudged(&scene, 4).map(|scene| differences(&of(on_cpu(scene, &options, 10))));
        let chance = chance.fold([0.0; 4], |most: [f64; 4], new| [0, 1, 2, 3].map(|k| most[k].max(new[k])));
        if (0..4).any(|k| found[k] > (2.0 * chance[k]).clamp(1e-3, 5e-3)) {
            apart.push(format!("{solver:?}, {name}: {found:?}, by chance {chance:?}: {there:?} {here:?}"));
        }
    }
    assert!(apart.is_empty(), "{apart:#?}");
}

#[test]
fn two_runs_give_the_same_bits() {
    let Some(gpu) = device() else { return };
    let bits = |lists: Lists| lists.map(|l| l.iter().map(|v| v.map(f32::to_bits)).collect::<Vec<_>>());
    for (solver, name, scene) in solved() {
        let options = Options { solver, iterations: 2, pyramid: 2, polish: Some(1), ..Options::default() };
        let run = || bits(on_gpu(scene.clone(), &options, &gpu, 20));
        assert!(run() == run(), "{name}");
    }
}

#[test]
fn seams_stay_closed_for_ten_seconds() {
    let Some(gpu) = device() else { return };
    for (fold, solver) in [2, 3, 4].into_iter().flat_map(|fold| SOLVERS.map(|solver| (fold, solver))) {
        let cloth = support::hung_tube(fold);
        let rings: Vec<Vec<u32>> = (0..cloth.len() as u32).filter_map(|k| Some(cloth.ring_of(k)?.to_vec())).collect();
        let scene = Scene { colliders: support::below(), ..support::scene(cloth) };
        let [now, before, normals] =
            on_gpu(scene, &Options { solver, substeps: Some(4), pyramid: 2, ..Options::default() }, &gpu, 600);
        for list in [now, before, normals] {
            for ring in &rings {
                assert!(ring.iter().all(|k| list[*k as usize] == list[ring[0] as usize]), "ring of {fold}");
            }
            assert!(list.as_flattened().iter().all(|x| x.is_finite()));
        }
    }
}

#[test]
fn changes_reach_the_device() {
    let Some((device, queue)) = device() else { return };
    let run = |backend, solver| {
        let options = Options { solver, substeps: Some(4), pyramid: 3, ..Options::default() };
        let options = Options { backend, ..options.clone() };
        let mut stepper = Stepper::new(support::on_colliders(16), options, Some((&device, &queue))).unwrap();
        let mut colliders = support::all_colliders();
        for frame in 0..12 {
            match frame {
                2 => stepper.set_pinned(0, 17, true).unwrap(),
                3 => stepper.set_position(0, 17, [0.1, 0.2, 0.1]).unwrap(),
                4 => colliders[1].center[1] += 0.1,
                5 => drop(colliders.pop()),
                6 => stepper.set_wind(Some(support::wind(true))).unwrap(),
                8 => stepper.set_pinned(0, 17, false).unwrap(),
                9 => stepper.set_options(Options { substeps: Some(6), ..options_of(&stepper) }).unwrap(),
                10 => stepper.set_asleep(0, true).unwrap(),
                11 => stepper.set_gravity([0.0, -5.0, 1.0]).unwrap(),
                _ => {}
            }
            if frame == 4 || frame == 5 {
                stepper.set_colliders(colliders.clone()).unwrap();
            }
            let mut encoder = device.create_command_encoder(&Default::default());
            stepper.record(&mut encoder, FRAME).unwrap();
            queue.submit([encoder.finish()]);
        }
        assert_eq!(stepper.backend(), backend);
        read_back(&device, &queue, &stepper.buffers(0).unwrap().now).unwrap()
    };
    for solver in SOLVERS {
        let (there, here) = (run(Backend::Gpu, solver), run(Backend::Cpu, solver));
        assert!(largest(&there, &here) < 1e-4, "{solver:?}: {}", largest(&there, &here));
    }
}

fn options_of(stepper: &Stepper) -> Options {
    stepper.options().clone()
}

#[test]
fn a_fault_is_taken_back_on_both_backends() {
    let Some((device, queue)) = device() else { return };
    let run = |backend| {
        // Tethers would draw it back before it does any harm.
        let options = Options { backend, solver: Solver::Xpbd, substeps: Some(4), tethers: 0, ..Options::default() };
        let mut stepper = Stepper::new(scene::builtin("s1", 17).unwrap(), options, Some((&device, &queue))).unwrap();
        let mut good = Vec::new();
        for frame in 0..40 {
            if frame == 20 {
                // Finite numbers whose product is none.
                let mut matrix = [[0.0; 4]; 4];
                (matrix[0][0], matrix[1][1], matrix[2][2], matrix[3][3]) = (3e38, 3e38, 3e38, 1.0);
                stepper.transform(0, &[5 * 17 + 5], matrix).unwrap();
            }
            let mut encoder = device.create_command_encoder(&Default::default());
            stepper.record(&mut encoder, FRAME).unwrap();
            queue.submit([encoder.finish()]);
            let now = read_back(&device, &queue, &stepper.buffers(0).unwrap().now).unwrap();
            assert!(now.iter().all(|p| p[..3].iter().all(|x| x.abs() < 3.0)), "frame {frame}");
            match frame {
                19 => good = now,
                20 => assert_eq!(largest(&now, &good), 0.0, "{backend:?}"),
                _ => {}
            }
        }
        if backend == Backend::Gpu {
            let faults = stepper.buffers(0).unwrap().faults.as_ref().unwrap();
            let faults = read_back_u32(&device, &queue, faults).unwrap();
            assert_eq!((faults[0], faults[1]), (0, 1));
            assert!(faults[2] > 0);
        } else {
            let faults = stepper.take_faults();
            assert_eq!((faults.len(), faults[0].cloth), (1, 0));
            assert!((faults[0].time - 21.0 * FRAME).abs() < 1e-9 && faults[0].particles > 0, "{faults:?}");
            assert!(stepper.take_faults().is_empty());
        }
        read_back(&device, &queue, &stepper.buffers(0).unwrap().now).unwrap()
    };
    let (there, here) = (run(Backend::Gpu), run(Backend::Cpu));
    assert!(largest(&there, &here) < 1e-4, "{}", largest(&there, &here));
}

#[test]
fn another_stepper_compiles_nothing_that_the_first_has() {
    let Some((device, queue)) = support::device() else { return };
    let options = Options { backend: Backend::Gpu, ..Options::default() };
    let made = |scene: &Scene, from: Option<&Stepper>| match from {
        Some(stepper) => stepper.another(scene.clone(), options.clone()).unwrap(),
        None => Stepper::new(scene.clone(), options.clone(), Some((&device, &queue))).unwrap(),
    };
    let [small, other] = [support::scene(support::curtain(8)), support::on_colliders(8)];
    let first = made(&small, None);
    assert!(first.compiled().unwrap().pipelines > 0 && first.compiled().unwrap().ms > 0.0);
    assert_eq!(made(&small, Some(&first)).compiled().unwrap(), Compiled::default());
    assert!(made(&other, Some(&first)).compiled().unwrap().pipelines > 0);
    // A frame compiles nothing more.
    let mut again = made(&small, Some(&first));
    let mut encoder = device.create_command_encoder(&Default::default());
    again.record(&mut encoder, 1.0 / 60.0).unwrap();
    queue.submit([encoder.finish()]);
    assert_eq!(again.compiled().unwrap().pipelines, 0);
}

/// A device with all that the runtime can use, timestamp queries among it.
fn device_with_times() -> Option<(wgpu::Device, wgpu::Queue)> {
    let adapter = support::any()?;
    let required_features = device_features(&adapter);
    if required_features.is_empty() {
        return support::lacking("the adapter has no timestamp queries");
    }
    let wish = wgpu::DeviceDescriptor { required_features, ..Default::default() };
    pollster::block_on(adapter.request_device(&wish)).map_or_else(|e| support::lacking(&e.to_string()), Some)
}

#[test]
fn each_pass_is_timed_and_results_stay_the_same() {
    let Some(gpu) = device_with_times() else { return };
    for fused in [true, false] {
        let options = Options { fused, ..Options::default() };
        let scene = scene(support::tube(9, 20, 4));
        let [mut timed, mut plain] = [(); 2].map(|()| Rig::gpu(scene.clone(), &options, &gpu));
        assert!(timed.stepper.time_passes(true));
        for rig in [&mut timed, &mut plain] {
            (0..8).for_each(|_| rig.frame_to_its_end(FRAME));
        }
        assert_eq!(timed.positions(0), plain.positions(0));
        assert!(plain.stepper.pass_times().is_empty());
        // Of each shader as many dispatches as the plan has, and time for some.
        let mut planned = std::collections::BTreeMap::new();
        timed.stepper.plan().passes.iter().for_each(|p| *planned.entry(p.shader).or_insert(0) += p.dispatches);
        let times = timed.stepper.pass_times().to_vec();
        let found: std::collections::BTreeMap<_, _> = times.iter().map(|t| (t.shader, t.dispatches)).collect();
        assert_eq!((found, times.len()), (planned.clone(), planned.len()));
        let all: f64 = times.iter().map(|t| t.ms).sum();
        assert!(times.iter().all(|t| t.ms >= 0.0) && all > 0.0 && all < 10_000.0, "{times:?}");
        assert!(timed.stepper.time_passes(false));
    }
    // The CPU, and a device without timestamps.
    let scene = scene(support::tube(9, 4, 4));
    let mut cpu = Rig::on(Backend::Cpu, scene.clone(), &Options::default(), &gpu);
    assert!(!cpu.stepper.time_passes(true));
    let Some(plain) = device() else { return };
    assert!(!Rig::gpu(scene, &Options::default(), &plain).stepper.time_passes(true));
}

#[test]
fn a_gpu_with_timestamps_keeps_to_a_budget_by_itself() {
    let Some(gpu) = device_with_times() else { return };
    let options = Options { substeps: Some(8), quality: Quality::Budget(1e-6), ..Options::default() };
    let mut rig = Rig::gpu(scene(support::tube(9, 20, 4)), &options, &gpu);
    for _ in 0..60 {
        rig.frame_to_its_end(FRAME);
        // The clock of the host has no say.
        rig.stepper.took(8, 1e-9);
    }
    assert_eq!(rig.stepper.substeps(), 1);
}
