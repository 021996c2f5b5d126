//! Contact of the tier safe on the GPU: no triangle crosses another one in any frame.

use crate::support::rig::{Rig, center, largest};
use crate::support::{self, calm, device, draped, dropped, folded, with_tier};
use gimage_runtime::crossings::{self, Drawn};
use gimage_runtime::*;

/// Frames in which a second run is compared with the first one.
const REPEATED: u32 = 20;

fn options() -> Options {
    Options { threads: 1, normals: false, ..Options::default() }
}

fn crossings_of(scene: &Scene, rig: &Rig) -> u64 {
    let now: Vec<_> = (0..scene.cloths.len()).map(|c| rig.positions(c)).collect();
    let drawn: Vec<Drawn> = scene.cloths.iter().zip(&now).map(|(cloth, now)| Drawn::at(cloth, now)).collect();
    crossings::find(&drawn, 0).unwrap().total()
}

fn positions(scene: &Scene, rig: &Rig) -> Vec<[f32; 4]> {
    (0..scene.cloths.len()).flat_map(|c| rig.positions(c)).collect()
}

#[test]
fn no_frame_of_folding_dropping_or_draping_cloth_has_a_crossing() {
    let Some(gpu) = device() else { return };
    for (scene, share, frames) in [(folded(33, 0.01), 1.2, 12), (dropped(15), 0.4, 60), (draped(11), 0.4, 45)] {
        let name = scene.name.clone();
        let mut free = Rig::gpu(with_tier(scene.clone(), ContactTier::Particles, share), &options(), &gpu);
        let scene = with_tier(scene, ContactTier::Safe, share);
        let mut held = free.another(&scene);
        let mut again = held.another(&scene);
        let mut crossed = 0;
        for frame in 0..frames {
            [&mut free, &mut held].into_iter().for_each(|rig| rig.frame_to_its_end(support::FRAME));
            crossed += crossings_of(&scene, &free);
            assert_eq!(crossings_of(&scene, &held), 0, "{name}, frame {frame}");
            if frame < REPEATED {
                again.frame_to_its_end(support::FRAME);
                assert_eq!(
                    positions(&scene, &held),
                    positions(&scene, &again),
                    "{name}, frame {frame} does not repeat"
                );
            }
        }
        assert!(crossed > 0, "{name} does not need this tier");
        assert_eq!(held.stepper.findings(), [], "{name}");
        // It falls as far, and does not freeze in the air.
        let mean = |rig: &Rig| center(&positions(&scene, rig), |_| true);
        let (held, free) = (mean(&held), mean(&free));
        let off = (0..3).map(|c| (held[c] - free[c]).powi(2)).sum::<f64>().sqrt();
        assert!(off < 0.06, "{name}: {held:?} with the tier safe, {free:?} without");
    }
}

/// Where the host finds crossings: whether there are any, and whether pins left cloth no room.
fn crossed(rig: &mut Rig) -> Option<(bool, bool)> {
    for cloth in 0..rig.stepper.scene().cloths.len() {
        let (now, before) = (rig.positions(cloth), rig.previous(cloth));
        rig.stepper.examine(cloth, &now, &before).unwrap();
    }
    rig.stepper.findings().iter().find_map(|finding| match finding.fate {
        Fate::Crossed { pairs, forced, .. } => Some((pairs > 0, forced > 0)),
        _ => None,
    })
}

#[test]
fn cloth_that_is_put_where_it_crosses_or_is_forced_to_cross_is_reported() {
    let Some(gpu) = device() else { return };
    let mut scene = Scene::new("crossed");
    scene.gravity = [0.0; 3];
    scene.cloths.push(calm(Flat::square("flat", 9)));
    // Cloths that cross at the start are taken apart: this one is put there later.
    let upright = Flat { origin: [2.03, 0.47, 0.51], down: [0.05, -1.0, 0.02], ..Flat::square("upright", 9) };
    scene.cloths.push(calm(upright));
    let mut rig = Rig::gpu(with_tier(scene, ContactTier::Safe, 0.5), &options(), &gpu);
    rig.frame_to_its_end(support::FRAME);
    let aside = [[1.0, 0.0, 0.0, 0.0], [0.0, 1.0, 0.0, 0.0], [0.0, 0.0, 1.0, 0.0], [-2.0, 0.0, 0.0, 1.0]];
    rig.stepper.transform(1, &(0..81).collect::<Vec<_>>(), aside).unwrap();
    rig.frame_to_its_end(support::FRAME);
    assert_eq!(crossed(&mut rig), Some((true, false)));

    // The middle of one square is dragged through another one, whose sides are pinned.
    let mut scene = Scene::new("dragged");
    scene.gravity = [0.0; 3];
    for (height, name) in [(0.0, "lower"), (0.06, "upper")] {
        scene.cloths.push(calm(Flat { origin: [0.0, height, 0.0], ..Flat::square(name, 9) }));
    }
    (0..81).filter(|k| k % 9 == 0 || k % 9 == 8 || k / 9 == 0 || k / 9 == 8).for_each(|k| {
        scene.cloths[0].set_pinned(k, true).unwrap();
    });
    scene.cloths[1].set_pinned(40, true).unwrap();
    let scene = with_tier(scene, ContactTier::Safe, 0.3);
    let mut rig = Rig::gpu(scene.clone(), &options(), &gpu);
    let mut at = rig.positions(1)[40];
    let (mut dent, mut crosses) = (0.0f32, 0);
    let found = (0..60).find_map(|_| {
        at[1] -= 0.02;
        rig.stepper.set_pins(1, &[40], &[[at[0], at[1], at[2]]]).unwrap();
        rig.frame_to_its_end(support::FRAME);
        let crosses_now = crossings_of(&scene, &rig) > 0;
        crosses += u32::from(crosses_now);
        if !crosses_now {
            dent = rig.positions(0).iter().map(|p| p[1]).fold(dent, f32::min);
        }
        // Counts arrive some frames late.
        let found = crossed(&mut rig);
        assert!(found.is_some() || crosses < 5, "{crosses} frames cross");
        found
    });
    assert_eq!(found, Some((true, true)));
    assert!(dent < -0.03, "the lower square gives way by {dent} m before");
}

#[test]
fn cloth_that_came_apart_on_the_host_stays_apart_on_the_device() {
    let Some(gpu) = device() else { return };
    let mut scene = Scene::new("overlap");
    scene.colliders.push(Collider { friction: 0.5, ..Collider::new(Shape::HalfSpace, [0.0; 3]) });
    scene.cloths.push(calm(Flat { origin: [-0.5, 0.1, -0.5], ..Flat::square("flat", 13) }));
    let tilted = Flat { origin: [-0.49, 0.07, -0.49], right: [1.0, 0.1, 0.02], ..Flat::square("tilted", 13) };
    scene.cloths.push(calm(tilted));
    let scene = with_tier(scene, ContactTier::Safe, 1.0);
    let mut host = Rig::cpu(scene.clone(), &options());
    assert!(crossings_of(&scene, &host) > 10);
    host.frames(45);
    assert_eq!(crossings_of(&scene, &host), 0);
    let state = host.stepper.snapshot().unwrap();
    let mut rig = Rig::gpu(scene.clone(), &options(), &gpu);
    rig.stepper.restore(&state).unwrap();
    for frame in 0..10 {
        rig.frame_to_its_end(support::FRAME);
        assert_eq!(crossings_of(&scene, &rig), 0, "frame {frame}");
    }
    assert!(largest(&rig.positions(1), &host.positions(1)) > 1e-5, "it goes on");
}

#[test]
fn sleeping_cloth_is_in_the_way() {
    let Some(gpu) = device() else { return };
    let mut scene = Scene::new("asleep");
    scene.colliders.push(Collider { friction: 0.5, ..Collider::new(Shape::HalfSpace, [0.0; 3]) });
    scene.cloths.push(calm(Flat { origin: [0.0, 0.0, 0.0], ..Flat::square("lower", 11) }));
    let small =
        Flat { origin: [0.2, 0.25, 0.2], right: [0.6, 0.1, 0.0], down: [0.0, 0.1, 0.6], ..Flat::square("upper", 9) };
    scene.cloths.push(calm(small));
    let mut scene = with_tier(scene, ContactTier::Safe, 0.2);
    // It lies on the lower one, which lies on the table.
    scene.cloths[0].contact = scene.cloths[0].contact.map(|c| ClothContact { distance: Some(0.004), ..c });
    let options = Options { sleep: Some(Sleep { speed: 0.1, after: 0.05 }), ..options() };
    let mut rig = Rig::gpu(scene.clone(), &options, &gpu);
    let mut asleep = 0;
    for frame in 0..40 {
        rig.frame_to_its_end(support::FRAME);
        assert_eq!(crossings_of(&scene, &rig), 0, "frame {frame}");
        asleep += u32::from(rig.stepper.is_asleep(0) && !rig.stepper.is_asleep(1));
    }
    assert!(asleep > 3, "one falls while the other one sleeps, {asleep} frames");
    let lowest = rig.positions(1).iter().map(|p| p[1]).fold(f32::MAX, f32::min);
    assert!(lowest < 0.05, "it has landed: {lowest} m");
}

#[test]
fn cloth_that_nothing_is_near_moves_as_without_contact() {
    let Some(gpu) = device() else { return };
    let mut scene = Scene::new("flag");
    let mut cloth = calm(Flat { origin: [0.0, 1.0, 0.0], down: [0.0, -1.0, 0.2], ..Flat::square("flag", 17) });
    [0, 16].into_iter().for_each(|k| cloth.set_pinned(k, true).unwrap());
    scene.cloths.push(cloth);
    let scene = with_tier(scene, ContactTier::Particles, 0.8);
    let safe = with_tier(scene.clone(), ContactTier::Safe, 0.8);
    let mut rigs = [scene, safe].map(|scene| Rig::gpu(scene, &options(), &gpu));
    for frame in 0..30 {
        rigs.iter_mut().for_each(|rig| rig.frames(1));
        assert_eq!(rigs[0].positions(0), rigs[1].positions(0), "frame {frame}");
        assert_eq!(rigs[0].previous(0), rigs[1].previous(0), "frame {frame}");
    }
    assert!(largest(&rigs[0].positions(0), &rigs[0].previous(0)) > 1e-4, "it swings");
}
