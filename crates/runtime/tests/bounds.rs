//! Boxes around cloths, known without a wait.

use crate::support::rig::{FRAME, Rig};
use crate::support::{self, curtain, device_with, on_colliders, scene, tube};
use gimage_runtime::scene::Pose;
use gimage_runtime::*;

fn options() -> Options {
    Options { substeps: Some(3), threads: 1, ..Options::default() }
}

/// Cloths of several sizes, one with seams and one that falls on colliders.
fn all() -> Scene {
    let mut all = on_colliders(12);
    all.cloths.extend([curtain(9), tube(17, 12, 3)]);
    all
}

/// The corners around a cloth's particles, now and one step before.
fn corners(rig: &Rig, cloth: usize) -> [[f32; 3]; 2] {
    let lists = [rig.positions(cloth), rig.previous(cloth)];
    let there = |k: &usize| lists[0][*k][3] >= 0.0;
    let all = || lists.iter().flat_map(|list| (0..list.len()).filter(there).map(|k| list[k]));
    [f32::min as fn(f32, f32) -> f32, f32::max].map(|pick| [0, 1, 2].map(|c| all().map(|p| p[c]).reduce(pick).unwrap()))
}

/// Submits what `record` records, and takes in what comes back.
fn submit(
    rig: &mut Rig,
    device: &(wgpu::Device, wgpu::Queue),
    record: impl FnOnce(&mut Stepper, &mut wgpu::CommandEncoder),
) {
    let mut encoder = device.0.create_command_encoder(&Default::default());
    record(&mut rig.stepper, &mut encoder);
    device.1.submit([encoder.finish()]);
    rig.stepper.settle().unwrap();
}

/// Waits until everything has arrived.
fn arrive(rig: &mut Rig, device: &(wgpu::Device, wgpu::Queue)) {
    device.0.poll(wgpu::PollType::wait_indefinitely()).unwrap();
    rig.stepper.settle().unwrap();
}

#[test]
fn a_box_is_that_of_all_particles() {
    let mut cpu = Rig::cpu(all(), &options());
    cpu.frames(5);
    for cloth in 0..3 {
        let found = cpu.stepper.bounds(cloth).unwrap();
        assert_eq!(([found.low, found.high], found.age), (corners(&cpu, cloth), 0.0));
        let (now, before) = (cpu.positions(cloth), cpu.previous(cloth));
        let ways = now.iter().zip(&before).map(|(p, q)| (0..3).map(|c| (p[c] - q[c]).powi(2)).sum::<f32>());
        let speed = ways.reduce(f32::max).unwrap().sqrt() * 180.0;
        assert!((found.speed - speed).abs() < 1e-3 * speed, "{found:?} {speed}");
        assert_eq!(found.grown(0.25).high[1], found.high[1] + 0.25);
    }
    assert_eq!(cpu.stepper.bounds(3), None);
    let Some(roomy) = device_with(device_limits) else { return };
    let mut gpu = Rig::gpu(all(), &options(), &roomy);
    assert_eq!(gpu.stepper.bounds(0), None, "none has arrived");
    gpu.frames(4);
    submit(&mut gpu, &roomy, |stepper, encoder| {
        stepper.record(encoder, FRAME).unwrap();
        stepper.record_bounds(encoder).unwrap();
    });
    let there: Vec<_> = (0..3).map(|cloth| corners(&gpu, cloth)).collect();
    // It is two frames late.
    gpu.frames(2);
    arrive(&mut gpu, &roomy);
    for (cloth, corners) in there.into_iter().enumerate() {
        let (found, twin) = (gpu.stepper.bounds(cloth).unwrap(), cpu.stepper.bounds(cloth).unwrap());
        assert_eq!([found.low, found.high], corners, "cloth {cloth}");
        assert!((found.age - 2.0 * FRAME).abs() < 1e-9, "{found:?}");
        assert!((found.speed - twin.speed).abs() < 0.1 * twin.speed, "{found:?} {twin:?}");
        // No particle has gone faster by more than gravity makes it.
        let (now, later) = (self::corners(&gpu, cloth), found.grown(0.02));
        assert!((0..3).all(|c| later.low[c] <= now[0][c] && now[1][c] <= later.high[c]), "{now:?} {later:?}");
    }
}

/// A curtain that begins at some x \[m\].
fn at(x: f32) -> Cloth {
    let mut cloth = curtain(5);
    cloth.place(cloth.positions().iter().map(|p| [p[0] + x, p[1], p[2]]).collect()).unwrap();
    cloth
}

#[test]
fn boxes_follow_their_cloths_where_others_come_and_go() {
    let mut start = scene(at(0.0));
    start.cloths.extend([at(10.0), at(20.0)]);
    let (gone, there) = (None, |x: f32| Some([x, x + 1.0]));
    for mut rig in Rig::both(&start, &options()) {
        let device = rig.device().cloned();
        // On the GPU the boxes are under way when cloths come and go after it.
        let measure = |rig: &mut Rig| {
            rig.frame(FRAME);
            if let Some((device, queue)) = &device {
                let mut encoder = device.create_command_encoder(&Default::default());
                rig.stepper.record_bounds(&mut encoder).unwrap();
                queue.submit([encoder.finish()]);
            }
        };
        // From where to where along x the boxes of some cloths are, to a centimetre.
        let found = |rig: &mut Rig, cloths: &[ClothHandle]| -> Vec<Option<[f32; 2]>> {
            device.iter().for_each(|device| (0..2).for_each(|_| arrive(rig, device)));
            let x = |b: Bounds| [b.low[0], b.high[0]].map(|x| (x * 100.0).round() / 100.0);
            cloths.iter().map(|cloth| rig.stepper.bounds(*cloth).map(x)).collect()
        };
        let known_at_once = |x: f32| there(x).filter(|_| device.is_none());
        let mut all = rig.stepper.handles().to_vec();
        measure(&mut rig);
        rig.stepper.remove_cloth(all[0]).unwrap();
        all.push(rig.stepper.add_cloth(at(30.0)).unwrap());
        assert_eq!(found(&mut rig, &all), [gone, there(10.0), there(20.0), known_at_once(30.0)], "{}", rig.name());
        assert_eq!(rig.stepper.bounds(0), rig.stepper.bounds(all[1]));
        rig.stepper.remove_cloth(all[1]).unwrap();
        assert_eq!(found(&mut rig, &all), [gone, gone, there(20.0), known_at_once(30.0)], "{}", rig.name());
        // Measured once more than there is room for, where the last ones have not arrived.
        measure(&mut rig);
        all.extend([40.0, 50.0, 60.0].map(|x| rig.stepper.add_cloth(at(x)).unwrap()));
        measure(&mut rig);
        rig.stepper.remove_cloth(all[2]).unwrap();
        let expected = [gone, gone, gone, there(30.0), there(40.0), there(50.0), there(60.0)];
        assert_eq!(found(&mut rig, &all), expected, "{}", rig.name());
        measure(&mut rig);
        assert_eq!(found(&mut rig, &all), expected, "{}", rig.name());
        let [low, high] = corners(&rig, 3);
        let last = rig.stepper.bounds(all[6]).unwrap();
        assert_eq!((last.low, last.high, last.age), (low, high, 0.0));
    }
}

#[test]
fn a_cloth_that_is_moved_has_no_box_of_before() {
    let Some(device) = support::device() else { return };
    let mut gpu = Rig::gpu(scene(curtain(9)), &Options { fused: false, ..options() }, &device);
    gpu.frame(FRAME);
    let state = gpu.stepper.state(0).unwrap();
    let measure = |stepper: &mut Stepper, encoder: &mut wgpu::CommandEncoder| stepper.record_bounds(encoder).unwrap();
    submit(&mut gpu, &device, measure);
    // On its way when the cloth is moved.
    gpu.stepper.teleport(0, &Pose { position: [50.0, 0.0, 0.0], ..Pose::default() }).unwrap();
    arrive(&mut gpu, &device);
    assert_eq!(gpu.stepper.bounds(0), None);
    // The teleport waits for the next frame, and is done before the cloth is measured.
    submit(&mut gpu, &device, measure);
    arrive(&mut gpu, &device);
    let found = gpu.stepper.bounds(0).unwrap();
    assert!(found.low[0] >= 49.99 && found.high[0] <= 51.01, "{found:?}");
    gpu.stepper.set_state(0, &state).unwrap();
    assert_eq!(gpu.stepper.bounds(0), None);
    // More calls than may be in flight are skipped, and not an error; each that is recorded arrives.
    let mut encoder = device.0.create_command_encoder(&Default::default());
    (0..9).for_each(|_| gpu.stepper.record_bounds(&mut encoder).unwrap());
    device.1.submit([encoder.finish()]);
    gpu.stepper.settle().unwrap();
    arrive(&mut gpu, &device);
    assert!(gpu.stepper.bounds(0).unwrap().high[0] <= 1.01);
    gpu.frame(FRAME);
    submit(&mut gpu, &device, measure);
    arrive(&mut gpu, &device);
    assert_eq!(gpu.stepper.bounds(0).unwrap().age, 0.0);
    // After a cut as before.
    gpu.stepper.cut([0.5, -0.4, 3.0], [-4.0, -0.4, -2.0], [5.0, -0.4, -2.0]).unwrap();
    gpu.frames(20);
    submit(&mut gpu, &device, measure);
    arrive(&mut gpu, &device);
    let [low, high] = corners(&gpu, 0);
    let found = gpu.stepper.bounds(0).unwrap();
    assert_eq!((found.low, found.high), (low, high));
    // On the CPU backend there is nothing to record, with a device or without.
    let mut cpu = Stepper::on_cpu(scene(curtain(5)), options()).unwrap();
    let mut encoder = device.0.create_command_encoder(&Default::default());
    assert!(matches!(cpu.record_bounds(&mut encoder), Err(Error::NoGpu(_))));
    let on_cpu = Options { backend: Backend::Cpu, ..options() };
    let mut drawn = Stepper::new(scene(curtain(5)), on_cpu, Some((&device.0, &device.1))).unwrap();
    drawn.record_bounds(&mut encoder).unwrap();
    assert_eq!(drawn.bounds(0), cpu.bounds(0));
}
