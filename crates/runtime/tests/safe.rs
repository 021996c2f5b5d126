//! Contact of the tier safe: no triangle crosses another one in any frame.

use crate::support::{calm, draped, dropped, folded, with_tier};
use gimage_runtime::crossings::{self, Drawn};
use gimage_runtime::*;

const FRAME: f64 = 1.0 / 60.0;

fn options() -> Options {
    Options { threads: 1, normals: false, ..Options::default() }
}

fn crossings_of(scene: &Scene, stepper: &Stepper) -> u64 {
    let drawn: Vec<Drawn> = scene
        .cloths
        .iter()
        .enumerate()
        .map(|(c, cloth)| Drawn { cloth, positions: stepper.positions(c), holes: stepper.holes(c) })
        .collect();
    crossings::find(&drawn, 0).unwrap().total()
}

/// Steps some frames; returns frames with crossings, and the mean position of all particles.
fn run(scene: &Scene, frames: u32) -> (u32, [f64; 3], Vec<Finding>) {
    let mut stepper = Stepper::on_cpu(scene.clone(), options()).unwrap();
    let mut crossed = 0;
    for _ in 0..frames {
        stepper.advance(FRAME).unwrap();
        crossed += u32::from(crossings_of(scene, &stepper) > 0);
    }
    let all: Vec<_> = (0..scene.cloths.len()).flat_map(|c| stepper.positions(c).unwrap()).collect();
    let mean = [0, 1, 2].map(|c| all.iter().map(|p| f64::from(p[c])).sum::<f64>() / all.len() as f64);
    (crossed, mean, stepper.findings().to_vec())
}

#[test]
fn no_frame_of_folding_dropping_or_draping_cloth_has_a_crossing() {
    for (scene, share, frames) in [(folded(33, 0.01), 1.2, 12), (dropped(17), 0.4, 70), (draped(13), 0.4, 50)] {
        let name = scene.name.clone();
        let (crossed, free, _) = run(&with_tier(scene.clone(), ContactTier::Particles, share), frames);
        assert!(crossed > 0, "{name} does not need this tier");
        let (crossed, held, findings) = run(&with_tier(scene, ContactTier::Safe, share), frames);
        assert_eq!(crossed, 0, "{name}");
        assert_eq!(findings, [], "{name}");
        // It falls as far, and does not freeze in the air.
        let off = (0..3).map(|c| (held[c] - free[c]).powi(2)).sum::<f64>().sqrt();
        assert!(off < 0.06, "{name}: {held:?} with the tier safe, {free:?} without");
    }
}

#[test]
fn threads_do_not_change_a_bit_and_a_state_goes_on_as_it_was() {
    let scene = with_tier(draped(13), ContactTier::Safe, 0.6);
    let mut one = Stepper::on_cpu(scene.clone(), options()).unwrap();
    let mut three = Stepper::on_cpu(scene.clone(), Options { threads: 3, ..options() }).unwrap();
    let now = |stepper: &Stepper| {
        let lists = (0..3).flat_map(|c| [stepper.positions(c).unwrap(), stepper.previous(c).unwrap()]);
        lists.flatten().flatten().map(|x| x.to_bits()).collect::<Vec<u32>>()
    };
    for _ in 0..30 {
        one.advance(FRAME).unwrap();
        three.advance(FRAME).unwrap();
    }
    assert_eq!(now(&one), now(&three));
    let saved = one.snapshot().unwrap();
    let mut other = Stepper::on_cpu(scene, options()).unwrap();
    other.restore(&saved).unwrap();
    for frame in 0..10 {
        one.advance(FRAME).unwrap();
        other.advance(FRAME).unwrap();
        assert_eq!(now(&one), now(&other), "frame {frame}");
    }
}

#[test]
fn cloth_that_starts_crossed_or_is_forced_to_cross_is_reported() {
    let crossed = |stepper: &Stepper| {
        stepper.findings().iter().find_map(|finding| match finding.fate {
            Fate::Crossed { pairs, forced, .. } => Some((pairs > 0, forced > 0)),
            _ => None,
        })
    };
    let mut scene = Scene::new("crossed");
    scene.gravity = [0.0; 3];
    scene.cloths.push(calm(Flat::square("flat", 9)));
    let upright = Flat { origin: [0.03, 0.47, 0.51], down: [0.05, -1.0, 0.02], ..Flat::square("upright", 9) };
    scene.cloths.push(calm(upright));
    let scene = with_tier(scene, ContactTier::Safe, 0.5);
    let mut stepper = Stepper::on_cpu(scene, options()).unwrap();
    stepper.advance(FRAME).unwrap();
    assert_eq!(crossed(&stepper), Some((true, false)));

    // A corner of one square is dragged through another one, whose sides are pinned.
    let mut scene = Scene::new("dragged");
    scene.gravity = [0.0; 3];
    for (height, name) in [(0.0, "lower"), (0.06, "upper")] {
        scene.cloths.push(calm(Flat { origin: [0.0, height, 0.0], ..Flat::square(name, 9) }));
    }
    (0..81).filter(|k| k % 9 == 0 || k % 9 == 8 || k / 9 == 0 || k / 9 == 8).for_each(|k| {
        scene.cloths[0].set_pinned(k, true).unwrap();
    });
    scene.cloths[1].set_pinned(40, true).unwrap();
    let mut stepper = Stepper::on_cpu(with_tier(scene, ContactTier::Safe, 0.3), options()).unwrap();
    let mut at = stepper.positions(1).unwrap()[40];
    let mut found = None;
    for _ in 0..60 {
        at[1] -= 0.02;
        stepper.set_pins(1, &[40], &[[at[0], at[1], at[2]]]).unwrap();
        stepper.advance(FRAME).unwrap();
        found = found.or(crossed(&stepper));
    }
    assert_eq!(found, Some((true, true)));
}
