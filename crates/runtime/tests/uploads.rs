//! A frame uploads everything that it needs by one write of the queue.

use crate::support::rig::{FRAME, Rig};
use crate::support::run::Device;
use crate::support::{curtain, device_with, scene, two_charts, wind};
use gimage_runtime::scene::Pose;
use gimage_runtime::*;

fn options() -> Options {
    Options { backend: Backend::Gpu, substeps: Some(4), ..Options::default() }
}

fn capsules(count: usize, z: f32) -> Vec<Collider> {
    let shape = Shape::Capsule { radius: 0.1, half_height: 0.2 };
    (0..count).map(|k| Collider::new(shape, [0.3 * k as f32, -0.4, z])).collect()
}

/// Small cloths of two kinds, which share dispatches, and two that run by tiles, among capsules.
fn mixed() -> Scene {
    let mut all = scene(curtain(12));
    all.cloths.extend((0..8).map(|k| if k % 2 == 0 { curtain(12) } else { two_charts(9) }));
    all.cloths.extend([curtain(80), curtain(82)]);
    all.colliders = capsules(4, 0.3);
    all
}

/// The writes of a frame, `before` being done before it.
fn writes(stepper: &mut Stepper, (device, queue): &Device, before: impl FnOnce(&mut Stepper)) -> u64 {
    let count = stepper.uploads().unwrap().writes;
    before(stepper);
    let mut encoder = device.create_command_encoder(&Default::default());
    assert_eq!(stepper.record(&mut encoder, FRAME).unwrap().steps, 4);
    queue.submit([encoder.finish()]);
    stepper.uploads().unwrap().writes - count
}

#[test]
fn a_frame_in_which_everything_changes_is_one_write() {
    let Some(device) = device_with(device_limits) else { return };
    let windy = Scene { wind: Some(wind(false)), ..mixed() };
    let mut stepper = Stepper::new(windy, options(), Some((&device.0, &device.1))).unwrap();
    let row: Vec<u32> = (0..12).collect();
    for frame in 0..40 {
        let z = 0.3 + 0.001 * frame as f32;
        let count = writes(&mut stepper, &device, |stepper| {
            for again in 0..2 {
                stepper.set_colliders(capsules(4, z + 1e-4 * again as f32)).unwrap();
            }
            stepper.move_collider(1, &Pose { position: [0.3, -0.4, z + 0.01], ..Pose::default() }).unwrap();
            for cloth in [0, 2, 9] {
                let at: Vec<[f32; 3]> = row.iter().map(|k| [*k as f32 / 11.0, 0.001 * z, 0.0]).collect();
                stepper.set_pins(cloth, &row, &at).unwrap();
            }
            stepper.set_asleep(4, frame % 2 == 0).unwrap();
        });
        assert_eq!(count, 1, "frame {frame}");
    }
}

#[test]
fn a_frame_in_which_nothing_changes_writes_nothing() {
    let Some(device) = device_with(device_limits) else { return };
    let mut stepper = Stepper::new(mixed(), options(), Some((&device.0, &device.1))).unwrap();
    let counts: Vec<u64> = (0..12).map(|_| writes(&mut stepper, &device, |_| ())).collect();
    assert_eq!((counts[0], counts[2..].iter().sum::<u64>()), (1, 0), "{counts:?}");
    // Colliders that have moved once are written once.
    let moved = writes(&mut stepper, &device, |stepper| stepper.set_colliders(capsules(4, 0.31)).unwrap());
    let counts: Vec<u64> = (0..8).map(|_| writes(&mut stepper, &device, |_| ())).collect();
    assert_eq!((moved, counts.iter().sum::<u64>()), (1, 0), "{counts:?}");
}

#[test]
fn pins_in_bulk_are_one_write() {
    let Some(device) = device_with(device_limits) else { return };
    let mut flag = Flat { right: [1.0, 0.0, 0.0], down: [0.0, -0.01, 0.0], ..Flat::square("flag", 2) };
    (flag.width, flag.height) = (1402, 3);
    let mut cloth = flag.cloth().unwrap();
    let pins: Vec<u32> = (0..1402).collect();
    cloth.pin(&pins).unwrap();
    let start: Vec<[f32; 3]> = cloth.positions()[..1402].to_vec();
    let mut stepper = Stepper::new(scene(cloth), options(), Some((&device.0, &device.1))).unwrap();
    for frame in 1..6 {
        let at: Vec<[f32; 3]> = start.iter().map(|p| [p[0], p[1] + 0.01 * frame as f32, p[2]]).collect();
        let count = writes(&mut stepper, &device, |stepper| {
            for (pin, at) in pins.chunks(2).zip(at.chunks(2)) {
                stepper.set_pins(0, pin, at).unwrap();
            }
        });
        let now = read_back(&device.0, &device.1, &stepper.buffers(0).unwrap().now).unwrap();
        assert!(now[..1402].iter().zip(&at).all(|(p, at)| p[..3] == *at), "frame {frame}");
        assert_eq!(count, 1, "frame {frame}");
    }
}

#[test]
fn frames_that_are_recorded_ahead_keep_their_numbers_colliders_and_pins() {
    let Some(device) = device_with(device_limits) else { return };
    let windy = Scene { wind: Some(wind(false)), ..mixed() };
    let run = |ahead: usize| {
        let mut rig = Rig::gpu(windy.clone(), &options(), &device);
        let mut recorded = Vec::new();
        for frame in 0..32 {
            let z = 0.1 - 0.004 * frame as f32;
            let at = [[0.0, 0.001 * frame as f32, 0.0]];
            rig.stepper.set_colliders(capsules(4, z)).unwrap();
            rig.stepper.set_pins(0, &[0], &at).unwrap();
            let mut encoder = device.0.create_command_encoder(&Default::default());
            rig.stepper.record(&mut encoder, FRAME).unwrap();
            recorded.push(encoder.finish());
            if recorded.len() == ahead {
                device.1.submit(recorded.drain(..));
            }
        }
        [0, 3, 10].map(|cloth| rig.positions(cloth))
    };
    assert!(run(1) == run(8));
}
