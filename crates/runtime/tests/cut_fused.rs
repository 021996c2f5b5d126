//! Cloth that is cut runs whole frames, and gives the bits of separate passes.

use crate::support::alike::Bits;
use crate::support::run::{Device, Run};
use crate::support::{curtain, device_with, hung_tube, made_of, scene, two_charts, wind};
use gimage_runtime::*;

fn options(fused: bool) -> Options {
    Options { backend: Backend::Gpu, substeps: Some(4), fused, ..Options::default() }
}

fn all(run: &Run) -> Vec<Bits> {
    (0..run.stepper.scene().cloths.len()).map(|cloth| run.bits(cloth)).collect()
}

/// A stroke across everything at a height, or along everything at x.
fn stroke(run: &mut Run, across: bool, at: f32) {
    let [eye, a, b] = if across {
        [[0.45, at + 0.003, 3.0], [-4.0, at - 0.002, -2.0], [4.9, at + 0.001, -2.1]]
    } else {
        [[at, -0.4, 3.0], [at, -1.5, -2.0], [at, -0.2, -2.0]]
    };
    run.stepper.cut(eye, a, b).unwrap();
}

/// Removes a cloth, cuts the others, makes one whole again, cuts, restores the cut state, adds a cloth and cuts once more. Returns the states
/// of all cloths after each part.
fn play(scene: &Scene, fused: bool, device: &Device) -> Vec<Vec<Bits>> {
    let mut parts = Vec::new();
    let mut run = Run::new(scene, &options(fused), device);
    let gone = run.stepper.handle(1).unwrap();
    run.stepper.remove_cloth(gone).unwrap();
    let mut run = run.frames(2);
    let uncut = run.stepper.state(0).unwrap();
    stroke(&mut run, true, -0.33);
    let mut run = run.frames(3);
    let whole = run.holds().len();
    assert_eq!(whole, if fused { scene.cloths.len() - 1 } else { 0 }, "{}", run.stepper.plan());
    parts.push(all(&run));
    let holes = run.stepper.buffers(0).unwrap().holes.clone().unwrap();
    let gone = read_back_u32(&device.0, &device.1, &holes).unwrap().iter().filter(|bits| **bits > 0).count();
    assert!(gone > 5, "{gone} quads are cut");
    let cut = run.stepper.state(0).unwrap();
    // One cloth is whole again; the others stay cut.
    run.stepper.set_state(0, &uncut).unwrap();
    let mut run = run.frames(2);
    assert_eq!(run.holds().len(), whole, "{}", run.stepper.plan());
    parts.push(all(&run));
    stroke(&mut run, false, 0.43);
    let run = run.frames(2);
    parts.push(all(&run));
    let mut run = run;
    run.stepper.set_state(0, &cut).unwrap();
    run.stepper.add_cloth(curtain(9)).unwrap();
    let mut run = run.frames(1);
    stroke(&mut run, true, -0.61);
    let run = run.frames(2);
    assert_eq!(run.holds().len(), if fused { whole + 1 } else { 0 }, "{}", run.stepper.plan());
    parts.push(all(&run));
    parts
}

#[test]
fn whole_frames_of_cut_cloth_have_the_bits_of_separate_passes() {
    let Some(device) = device_with(device_limits) else { return };
    let three = |cloth: Cloth| Scene { cloths: vec![cloth.clone(), cloth.clone(), cloth], ..scene(curtain(3)) };
    let windy = |cloth: Cloth| Scene { wind: Some(wind(true)), ..three(cloth) };
    let mut ball = three(curtain(21));
    ball.colliders.push(Collider::new(Shape::Sphere { radius: 0.2 }, [0.5, -0.5, 0.1]));
    let scenes = [
        ("constant rest lengths and tethers", ball),
        ("seams", three(hung_tube(3))),
        ("charts in wind on triangles", windy(two_charts(12))),
        ("a material", three(made_of(curtain(16)))),
    ];
    for (name, scene) in scenes {
        let (one, apart) = (play(&scene, true, &device), play(&scene, false, &device));
        for (part, (one, apart)) in one.iter().zip(&apart).enumerate() {
            for (cloth, (a, b)) in one.iter().zip(apart).enumerate() {
                assert_eq!(a.difference(b), None, "{name}, part {part}, cloth {cloth}");
            }
        }
    }
}

#[test]
fn a_crowd_that_is_cut_stays_one_dispatch() {
    let Some(device) = device_with(device_limits) else { return };
    let mut many = scene(curtain(12));
    many.cloths.extend((1..100).map(|k| curtain(10 + k % 3)));
    let mut run = Run::new(&many, &options(true), &device);
    assert_eq!(run.stepper.plan().dispatches(), 1);
    stroke(&mut run, true, -0.4);
    let run = run.frames(1);
    assert_eq!(run.stepper.plan().dispatches(), 1);
    let lower = |k: usize| k >= 12 * 8;
    let start = run.bits(0);
    let run = run.whole_frames(30);
    let end = run.bits(0);
    let y = |bits: &Bits, k: usize| f32::from_bits(bits[0][k][1]);
    assert!((0..144).filter(|k| lower(*k)).all(|k| y(&end, k) < y(&start, k) - 0.5), "what is cut off falls");
    assert!((0..48).all(|k| (y(&end, k) - y(&start, k)).abs() < 0.05), "what hangs stays");
}
