//! Cloth that crosses at the start, on the GPU backend: it is taken apart before the first frame.

use crate::support::rig::Rig;
use crate::support::{self, device};
use gimage_runtime::crossings::{self, Drawn};
use gimage_runtime::*;

fn options() -> Options {
    Options { threads: 1, normals: false, ..Options::default() }
}

/// Two squares that cross along a line above a table, with contact of a tier in layers.
fn overlap(n: u32, tier: ContactTier, layers: [i32; 2]) -> Scene {
    let mut scene = Scene::new("overlap");
    for (name, [low, high], layer) in [("lower", [0.1, 0.1], layers[0]), ("upper", [0.06, 0.17], layers[1])] {
        let (right, down) = ([1.0, high - low, 0.02], [-0.02, 0.0, -1.0]);
        let beside = if low < high { 0.007 } else { 0.0 };
        let origin = [-0.5 + beside, low, 0.5 + beside];
        let mut cloth = Flat { origin, right, down, ..Flat::square(name, n) }.cloth().unwrap();
        cloth.damping = 0.5;
        cloth.contact = Some(ClothContact { tier, layer, ..ClothContact::default() });
        scene.cloths.push(cloth);
    }
    scene.colliders.push(Collider { friction: 0.5, ..Collider::new(Shape::HalfSpace, [0.0; 3]) });
    scene
}

fn crossings_of(rig: &Rig) -> u64 {
    let cloths = &rig.stepper.scene().cloths;
    let now: Vec<_> = (0..cloths.len()).map(|c| rig.positions(c)).collect();
    let drawn: Vec<Drawn> = cloths.iter().zip(&now).map(|(cloth, now)| Drawn::at(cloth, now)).collect();
    crossings::find(&drawn, 0).unwrap().total()
}

fn is_crossed(warning: &Warning) -> bool {
    matches!(warning, Warning::Crossed { .. })
}

#[test]
fn cloths_that_cross_at_the_start_are_apart_on_the_gpu_and_stay_so() {
    let Some(gpu) = device() else { return };
    for tier in [ContactTier::Particles, ContactTier::Safe] {
        let mut rig = Rig::gpu(overlap(20, tier, [0, 0]), &options(), &gpu);
        assert_eq!(crossings_of(&rig), 0, "{tier:?}: at the start");
        let warnings = rig.stepper.warnings();
        assert!(warnings.iter().any(|w| matches!(w, Warning::Crossed { left: 0, .. })), "{tier:?}: {warnings:?}");
        for frame in 1..=20 {
            rig.frame_to_its_end(support::FRAME);
            assert_eq!(crossings_of(&rig), 0, "{tier:?}, frame {frame}");
        }
        let all = (0..2).flat_map(|c| rig.positions(c)).map(|p| p[1]);
        assert!(all.fold(0.0, f32::max) < 0.3, "{tier:?}: nothing is thrown");
    }
}

#[test]
fn scenes_without_crossings_keep_their_bits_and_have_no_warning() {
    let mut scene = overlap(12, ContactTier::Particles, [0, 0]);
    scene.cloths.truncate(1);
    let before = scene.clone();
    assert_eq!(scene.take_apart(&options()).unwrap(), None);
    assert_eq!(scene, before);
    let Some(gpu) = device() else { return };
    let rig = Rig::gpu(scene, &options(), &gpu);
    assert!(!rig.stepper.warnings().iter().any(is_crossed));
    // Without contact cloths may cross.
    let mut scene = overlap(12, ContactTier::Particles, [0, 0]);
    scene.cloths.iter_mut().for_each(|cloth| cloth.contact = None);
    assert_eq!(scene.take_apart(&options()).unwrap(), None);
}

#[test]
fn the_higher_layer_comes_out_on_top_and_the_rest_of_a_scene_stays() {
    let mut scene = overlap(20, ContactTier::Particles, [1, 0]);
    let mut far = scene.cloths[0].clone();
    far.place(far.positions().iter().map(|p| [p[0] + 5.0, p[1], p[2]]).collect()).unwrap();
    scene.cloths.insert(0, far);
    scene.gravity = [0.0, -5.0, 0.0];
    let before = scene.clone();
    let taken = scene.take_apart(&options()).unwrap().unwrap();
    assert_eq!((taken.left, taken.cloths.len()), (0, 2), "{taken}");
    assert!(taken.pairs > 20 && taken.farthest > 0.01 && taken.farthest < 0.3, "{taken}");
    assert_eq!(scene.cloths[0], before.cloths[0], "cloth that crosses nothing");
    assert_eq!((scene.gravity, &scene.colliders), (before.gravity, &before.colliders));
    let height = |c: usize| scene.cloths[c].positions().iter().map(|p| p[1]).sum::<f32>();
    assert!(height(1) > height(2), "the first one has the higher layer");
    for (now, was) in scene.cloths.iter().zip(&before.cloths) {
        assert_eq!((now.damping, now.velocity, now.rest()), (was.damping, was.velocity, was.rest()));
    }
    // The same input gives the same bits, for any number of threads.
    let mut again = before;
    again.take_apart(&Options { threads: 3, ..options() }).unwrap();
    assert_eq!(again, scene);
}

#[test]
fn what_pins_hold_in_one_another_is_reported() {
    let mut scene = overlap(9, ContactTier::Particles, [0, 0]);
    for cloth in &mut scene.cloths {
        (0..cloth.len()).for_each(|k| cloth.set_pinned(k, true).unwrap());
    }
    let before = scene.clone();
    let taken = scene.take_apart(&options()).unwrap().unwrap();
    assert!(taken.left == taken.pairs && taken.to_string().contains("are left"), "{taken}");
    assert_eq!(scene, before);
    let Some(gpu) = device() else { return };
    let rig = Rig::gpu(scene, &options(), &gpu);
    let text = rig.stepper.warnings().iter().find(|w| is_crossed(w)).unwrap().to_string();
    assert!(text.contains("cloths lower, upper: ") && text.contains("start the layers apart"), "{text}");
}
