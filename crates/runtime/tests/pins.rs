//! Pins in bulk: many particles held, moved and freed by one call.

use crate::support::rig::{FRAME, Rig};
use crate::support::{self, curtain, tube, two_charts};
use gimage_runtime::*;

/// Where pins are after `frame` frames: a slow turn about y.
fn carried(at: &[[f32; 3]], frame: u32) -> Vec<[f32; 3]> {
    let (s, c) = (0.02 * frame as f32).sin_cos();
    at.iter().map(|[x, y, z]| [c * x + s * z, *y + 0.002 * frame as f32, c * z - s * x]).collect()
}

#[test]
fn bulk_and_single_calls_have_the_same_bits() {
    for cloth in [curtain(20), tube(17, 12, 4), two_charts(9)] {
        let chosen = cloth.select(&Select::Loop(0)).unwrap();
        let at: Vec<_> = chosen.iter().map(|k| cloth.positions()[*k as usize]).collect();
        let scene = support::scene(cloth);
        for (mut bulk, mut single) in
            Rig::both(&scene, &Options::default()).into_iter().zip(Rig::both(&scene, &Options::default()))
        {
            bulk.stepper.pin(0, &chosen).unwrap();
            chosen.iter().for_each(|k| single.stepper.set_pinned(0, *k as usize, true).unwrap());
            for frame in 1..20 {
                let to = carried(&at, frame);
                bulk.stepper.set_pins(0, &chosen, &to).unwrap();
                for (k, to) in chosen.iter().zip(&to) {
                    single.stepper.set_position(0, *k as usize, *to).unwrap();
                }
                bulk.frame(FRAME);
                single.frame(FRAME);
            }
            assert_eq!(bulk.positions(0), single.positions(0), "{}", bulk.name());
            assert_eq!(bulk.previous(0), single.previous(0), "{}", bulk.name());
            let (now, last) = (bulk.positions(0), carried(&at, 19));
            for (k, to) in chosen.iter().zip(&last) {
                let p = now[*k as usize];
                assert!(p[3] == 0.0 && p[..3] == *to, "{} {k}: {p:?}, not {to:?}", bulk.name());
            }
            bulk.stepper.unpin(0, &chosen).unwrap();
            bulk.frame(FRAME);
            assert!(chosen.iter().all(|k| bulk.positions(0)[*k as usize][3] > 0.0), "{}", bulk.name());
        }
    }
}

#[test]
fn backends_agree_on_pins() {
    let cloth = two_charts(9);
    let chosen = cloth.select(&Select::Box { low: [0.45, -0.3, -1.0], high: [0.55, 0.1, 1.0] }).unwrap();
    let at: Vec<_> = chosen.iter().map(|k| cloth.positions()[*k as usize]).collect();
    let run = |rig: &mut Rig| {
        rig.stepper.pin(0, &chosen).unwrap();
        for frame in 1..10 {
            rig.stepper.set_pins(0, &chosen, &carried(&at, frame)).unwrap();
            rig.frame(FRAME);
        }
        rig.positions(0)
    };
    let found: Vec<_> = Rig::both(&support::scene(cloth.clone()), &Options::default()).iter_mut().map(run).collect();
    for other in &found[1..] {
        let far = |(a, b): (&[f32; 4], &[f32; 4])| (0..4).map(|c| (a[c] - b[c]).abs()).fold(0.0, f32::max);
        let far = found[0].iter().zip(other).map(far).fold(0.0, f32::max);
        assert!(far < 1e-4, "{far:e}");
    }
}

#[test]
fn calls_take_effect_in_their_order_at_the_next_frame() {
    for mut rig in Rig::both(&support::scene(curtain(8)), &Options::default()) {
        rig.frames(2);
        let was = rig.positions(0);
        let shift = [[1.0, 0.0, 0.0, 0.0], [0.0, 1.0, 0.0, 0.0], [0.0, 0.0, 1.0, 0.0], [1.0, 0.0, 0.0, 1.0]];
        rig.stepper.set_pins(0, &[1], &[[5.0, 0.0, 0.0]]).unwrap();
        rig.stepper.transform(0, &[1, 2], shift).unwrap();
        rig.stepper.set_pins(0, &[2, 2], &[[8.0, 0.0, 0.0], [9.0, 0.0, 0.0]]).unwrap();
        rig.stepper.set_pinned(0, 20, true).unwrap();
        assert_eq!(rig.positions(0), was, "{}: it waits for the frame", rig.name());
        rig.frame(0.0);
        let now = rig.positions(0);
        assert_eq!((now[1][0], now[2][0], now[20][3]), (6.0, 9.0, 0.0), "{}", rig.name());
        assert_eq!(now[3], was[3]);
    }
}

#[test]
fn pins_wake_and_wrong_ones_are_named() {
    for mut rig in Rig::both(&support::scene(curtain(8)), &Options::default()) {
        let stepper = &mut rig.stepper;
        for change in 0..3 {
            stepper.set_asleep(0, true).unwrap();
            match change {
                0 => stepper.pin(0, &[9]).unwrap(),
                1 => stepper.unpin(0, &[9]).unwrap(),
                _ => stepper.set_pins(0, &[1], &[[0.0; 3]]).unwrap(),
            }
            assert!(!stepper.is_asleep(0), "{change}");
        }
        stepper.set_asleep(0, true).unwrap();
        let error = stepper.set_pins(0, &[1, 2], &[[0.0; 3]]).unwrap_err().to_string();
        assert!(error.contains("curtain: 1 positions for 2"), "{error}");
        let error = stepper.set_pins(0, &[1, 2], &[[0.0; 3], [0.0, f32::NAN, 0.0]]).unwrap_err();
        assert!(matches!(error, Error::NotFinite { index: 2, .. }), "{error}");
        assert!(stepper.pin(0, &[1, 64]).unwrap_err().to_string().contains("no particle 64"));
        assert!(stepper.set_pins(1, &[], &[]).is_err());
        assert!(stepper.set_position(0, usize::MAX, [0.0; 3]).is_err());
        assert!(stepper.is_asleep(0), "{}: nothing was done", rig.name());
    }
}

#[test]
fn positions_may_lie_in_a_buffer_of_the_host() {
    let Some((device, queue)) = support::device() else { return };
    let handles = (device.clone(), queue.clone());
    for cloth in [curtain(20), two_charts(9)] {
        let chosen = cloth.select(&Select::Pinned).unwrap();
        let at: Vec<_> = chosen.iter().map(|k| cloth.positions()[*k as usize]).collect();
        let scene = support::scene(cloth);
        let mut rigs = [0, 1].map(|_| Rig::gpu(scene.clone(), &Options::default(), &handles));
        let size = 256 + 16 * chosen.len() as u64;
        let usage = wgpu::BufferUsages::STORAGE | wgpu::BufferUsages::COPY_DST;
        let new = |usage| {
            device.create_buffer(&wgpu::BufferDescriptor { label: None, size, usage, mapped_at_creation: false })
        };
        let place = Span { buffer: new(usage), offset: 256, size: size - 256 };
        for frame in 1..10 {
            let to = carried(&at, frame);
            let bytes: Vec<u8> = to.iter().flat_map(|p| [p[0], p[1], p[2], 7.0]).flat_map(f32::to_ne_bytes).collect();
            queue.write_buffer(&place.buffer, 256, &bytes);
            let mut encoder = device.create_command_encoder(&Default::default());
            rigs[0].stepper.record_pins(&mut encoder, 0, &chosen, &place).unwrap();
            rigs[0].stepper.record(&mut encoder, FRAME).unwrap();
            queue.submit([encoder.finish()]);
            rigs[1].stepper.set_pins(0, &chosen, &to).unwrap();
            rigs[1].frame(FRAME);
        }
        assert_eq!(rigs[0].positions(0), rigs[1].positions(0));
        assert_eq!(rigs[0].previous(0), rigs[1].previous(0));
        let mut encoder = device.create_command_encoder(&Default::default());
        let stepper = &mut rigs[0].stepper;
        for (wrong, words) in [
            (Span { offset: 128, ..place.clone() }, "multiple of 256"),
            (Span { size: 16, ..place.clone() }, "16 bytes per particle"),
            (Span { offset: 512, ..place.clone() }, "make it larger"),
            (Span { buffer: new(wgpu::BufferUsages::COPY_DST), ..place.clone() }, "make it with the usage"),
        ] {
            let error = stepper.record_pins(&mut encoder, 0, &chosen, &wrong).unwrap_err().to_string();
            assert!(error.contains(words), "{error}");
        }
    }
}

#[test]
fn selections_are_those_of_scene_files() {
    let cloth = tube(17, 12, 1);
    let all = cloth.select(&Select::All).unwrap();
    assert_eq!(all.len(), 17 * 12);
    // Texel columns 0 and 16 are duplicates of one another.
    let column = cloth.select(&Select::Texels { piece: Some("tube"), from: [0, 2], to: [0, 3] }).unwrap();
    assert_eq!(column, [34, 50, 51, 67]);
    let loops = cloth.loops();
    assert_eq!(loops.len(), 2, "top and bottom");
    assert_eq!(cloth.select(&Select::Loop(1)).unwrap(), loops[1]);
    assert!(loops.iter().all(|l| l.len() == 17) && loops[0] != loops[1]);
    let low = cloth.select(&Select::Box { low: [f32::NEG_INFINITY; 3], high: [f32::INFINITY, -0.524, f32::INFINITY] });
    assert_eq!(low.unwrap(), (187..204).collect::<Vec<u32>>());
    let near = cloth.select(&Select::Sphere { center: [0.2, 0.0, 0.0], radius: 0.01 }).unwrap();
    assert_eq!(near, [0, 16]);
    let values: Vec<f32> = (0..204).map(|k| f32::from(u8::from(k == 16))).collect();
    assert_eq!(cloth.select(&Select::Map { values: &values, above: 0.5 }).unwrap(), [0, 16], "with its duplicate");
    for (wrong, words) in [
        (Select::Loop(2), "no boundary loop 2; there are 2"),
        (Select::Sphere { center: [0.0; 3], radius: 0.0 }, "above 0"),
        (
            Select::Texels { piece: Some("sleeve"), from: [0; 2], to: [0; 2] },
            "no piece \"sleeve\"; its pieces are tube",
        ),
        (Select::Map { values: &values[1..], above: 0.0 }, "203 values of a map for 204"),
    ] {
        let error = cloth.select(&wrong).unwrap_err().to_string();
        assert!(error.contains(words), "{error}");
    }
}
