//! Cases that one relaxation per step in f32 cannot handle, and the changes made instead.

use crate::support::rig::{FRAME, Rig, largest};
use crate::support::{self, scene};
use gimage_runtime::*;

fn options(substeps: u32, tethers: u32) -> Options {
    Options {
        solver: Solver::Xpbd,
        substeps: Some(substeps),
        tethers,
        threads: 1,
        normals: false,
        ..Options::default()
    }
}

fn flag(n: u32, place: impl Fn(usize) -> [f32; 3]) -> Cloth {
    let mut cloth = Flat::square("flag", n).cloth().unwrap();
    cloth.damping = 2.0;
    cloth.set_pinned(0, true).unwrap();
    cloth.set_pinned(n as usize - 1, true).unwrap();
    let pinned = |k: usize| cloth.particles()[k].is_pinned();
    let at = |k: usize| if pinned(k) { cloth.positions()[k] } else { place(k) };
    let list = (0..cloth.len()).map(at).collect();
    cloth.place(list).unwrap();
    cloth
}

fn stretch(rig: &Rig) -> f64 {
    let cloth = &rig.stepper.scene().cloths[0];
    measure(cloth, &rig.positions(0), &rig.previous(0), FRAME, [0.0; 3]).stretch_max
}

/// The fastest particle \[m/s\] over a frame.
fn speed(rig: &mut Rig) -> f32 {
    let before = rig.positions(0);
    rig.frame(FRAME);
    largest(&before, &rig.positions(0)) * 60.0
}

#[test]
fn heaps_in_one_plane_or_at_one_point_unfold_and_come_to_rest() {
    // Without a way out of the plane they tremble at several metres a second forever.
    let line = |k: usize| [0.5, -(k as f32) / 81.0, 0.0];
    for (words, heap) in [("a point", scene(flag(9, |_| [0.5, 0.0, 0.0]))), ("a line", scene(flag(9, line)))] {
        for mut rig in Rig::both(&heap, &options(16, 2)) {
            rig.frames(480);
            let (stretch, speed) = (stretch(&rig), speed(&mut rig));
            assert!(stretch < 0.05 && speed < 0.01, "{words}, {}: {stretch} {speed} m/s", rig.name());
        }
    }
}

#[test]
fn springs_without_length_go_the_same_way_on_both_backends() {
    let Some(device) = support::device() else { return };
    for fused in [false, true] {
        let options = Options { fused, ..options(2, 0) };
        let heap = scene(flag(9, |_| [0.5, 0.0, 0.0]));
        let (mut cpu, mut gpu) = (Rig::cpu(heap.clone(), &options), Rig::gpu(heap, &options, &device));
        [&mut cpu, &mut gpu].into_iter().for_each(|rig| rig.frame(FRAME / 2.0));
        let (a, b) = (cpu.positions(0), gpu.positions(0));
        assert!(largest(&a, &b) < 1e-4, "fused {fused}: {}", largest(&a, &b));
        let flat = |c: usize| a.iter().all(|p| (p[c] - a[40][c]).abs() < 1e-3);
        assert!((0..3).all(|c| !flat(c)), "it has left the point on every axis");
    }
}

#[test]
fn damping_does_its_work_in_steps_of_half_a_millisecond() {
    // 20 mm/s after 2 s at 2 /s: 0.37 mm/s. Rounded, what damping takes from a step's 10 um is nothing at all.
    // Without springs, whose own rounding counts too.
    let flat = Flat { origin: [0.6; 3], ..Flat::square("flat", 5) }.cloth().unwrap();
    let (positions, particles) = (flat.positions().to_vec(), flat.particles().to_vec());
    let (grids, mass) = (flat.grids().to_vec(), Mass::Constant(1e-3));
    let parts = Parts { name: "sand".into(), grids, positions, particles, rest: Rest::None, mass };
    let mut cloth = Cloth::new(parts).unwrap();
    (cloth.damping, cloth.velocity) = (2.0, [0.02, 0.0, 0.0]);
    let drifts = Scene { gravity: [0.0; 3], ..scene(cloth) };
    for fused in [true, false] {
        for mut rig in Rig::both(&drifts, &Options { fused, ..options(32, 0) }) {
            rig.frames(120);
            let speed = speed(&mut rig);
            assert!((2.5e-4..5e-4).contains(&speed), "{}, fused {fused}: {speed} m/s", rig.name());
        }
    }
}

#[test]
fn uneven_masses_are_evened_out_held_by_tethers_and_said() {
    let even = flag(9, |k| [(k % 9) as f32 / 8.0, 0.0, (k / 9) as f32 / 8.0]);
    let parts = Parts {
        name: "uneven".into(),
        grids: even.grids().to_vec(),
        positions: even.positions().to_vec(),
        particles: even.particles().to_vec(),
        rest: even.rest().clone(),
        mass: Mass::Image((0..81).map(|k| if k % 2 == 0 { 1.0 } else { 1e-6 }).collect()),
    };
    let mut cloth = Cloth::new(parts).unwrap();
    cloth.damping = 2.0;
    for tethers in [0, 2] {
        let mut rig = Rig::cpu(scene(cloth.clone()), &options(32, tethers));
        let warnings = rig.stepper.warnings();
        assert!(matches!(&warnings[0], Warning::Masses { particles: 40, limit, .. } if *limit == MOST_RATIO));
        let text = warnings[0].to_string();
        assert!(text.starts_with("cloth uneven: ") && text.contains("40 masses were changed"), "{text}");
        let given = matches!(warnings.get(1), Some(Warning::Tethers { given: 2, .. }));
        assert_eq!((given, warnings.len()), (tethers == 0, if tethers == 0 { 2 } else { 1 }));
        assert!((rig.stepper.scene().cloths[0].mass(1) * MOST_RATIO as f32 - 1.0).abs() < 1e-6);
        rig.frames(600);
        let (stretch, speed) = (stretch(&rig), speed(&mut rig));
        assert!(stretch < 0.05 && speed < 1e-3, "{tethers}: {stretch} {speed} m/s");
    }
    // The base line takes masses as they are.
    let classic = Rig::cpu(scene(cloth), &Options { solver: Solver::Classic, ..options(32, 0) });
    assert_eq!((classic.stepper.warnings(), classic.stepper.scene().cloths[0].mass(1)), (Vec::new(), 1e-6));
}

#[test]
fn steps_that_are_too_long_are_made_shorter_and_said() {
    let flat = || scene(flag(9, |k| [(k % 9) as f32 / 8.0, 0.0, (k / 9) as f32 / 8.0]));
    let made = |rig: &Rig| (rig.stepper.substeps(), rig.stepper.warnings().len());
    let long = |tethers, step: f64, substeps| Options { step, ..options(substeps, tethers) };
    for (tethers, step, asked, expected) in
        [(0, FRAME, 1, 2), (2, FRAME, 1, 1), (0, 0.1, 4, 12), (2, 0.1, 1, 6), (0, FRAME, 2, 2), (2, 1.0 / 30.0, 2, 2)]
    {
        let rig = Rig::cpu(flat(), &long(tethers, step, asked));
        assert_eq!(made(&rig), (expected, usize::from(expected > asked)), "{tethers} tethers, {asked} in {step} s");
    }
    // Later too, and what was said then is no longer said when it is no longer so.
    let mut rig = Rig::cpu(flat(), &long(0, FRAME, 8));
    assert_eq!(made(&rig), (8, 0));
    rig.stepper.set_options(long(0, FRAME, 1)).unwrap();
    assert_eq!(made(&rig), (2, 1));
    assert!(rig.stepper.warnings()[0].to_string().starts_with("1 substeps in 0.0167 s"));
    rig.stepper.set_options(long(0, FRAME, 3)).unwrap();
    assert_eq!(made(&rig), (3, 0));
    // It comes to rest at a step of a tenth of a second, by springs alone and by tethers.
    for tethers in [0, 2] {
        let mut rig = Rig::cpu(flat(), &long(tethers, 0.1, 1));
        (0..150).for_each(|_| rig.frame(0.1));
        let before = rig.positions(0);
        rig.frame(0.1);
        let speed = largest(&before, &rig.positions(0)) * 10.0;
        assert!(speed < 1e-3, "{tethers}: {speed} m/s");
    }
}

#[test]
fn a_fine_row_between_coarse_ones_is_held_by_tethers() {
    let at = |k: usize| [0.0f32, 0.16, 0.32, 0.48, 0.49, 0.65, 0.81, 0.97, 1.0][k];
    let mut cloth = flag(9, |k| [at(k % 9), 0.0, at(k / 9)]);
    let far = |a: usize, b: usize| (at(a) - at(b)).abs();
    let length = |k: usize| {
        let (i, j) = (k % 9, k / 9);
        let (x, y) = (if i < 8 { far(i, i + 1) } else { 0.0 }, if j < 8 { far(j, j + 1) } else { 0.0 });
        [x, y, 0.0, 0.0]
    };
    let parts = Parts {
        name: "fine".into(),
        grids: cloth.grids().to_vec(),
        positions: cloth.positions().to_vec(),
        particles: cloth.particles().to_vec(),
        rest: Rest::Image((0..81).map(length).collect()),
        mass: Mass::Constant(1e-3),
    };
    cloth = Cloth::new(parts).unwrap();
    let rig = Rig::cpu(scene(cloth.clone()), &options(8, 0));
    let warnings = rig.stepper.warnings();
    assert!(
        matches!(&warnings[..], [Warning::Tethers { lengths, masses, .. }]
            if (lengths / 16.0 - 1.0).abs() < 1e-3 && *masses == 1.0),
        "{warnings:?}"
    );
    // Nothing is given to cloth that no pin holds, or that has tethers.
    assert_eq!(Rig::cpu(scene(cloth.clone()), &options(8, 1)).stepper.warnings(), []);
    [0, 8].into_iter().for_each(|k| cloth.set_pinned(k, false).unwrap());
    assert_eq!(Rig::cpu(scene(cloth), &options(8, 0)).stepper.warnings(), []);
}

#[test]
fn cloth_that_does_not_come_to_rest_is_told_of() {
    let flat = || flag(9, |k| [(k % 9) as f32 / 8.0, 0.0, (k / 9) as f32 / 8.0]);
    let said = |cloth: Cloth, substeps| Rig::cpu(scene(cloth), &options(substeps, 2)).stepper.warnings();
    // By one corner, and by two that lie at one point.
    let mut one = flat();
    one.set_pinned(8, false).unwrap();
    let mut together = flat();
    together
        .place(together.positions().iter().enumerate().map(|(k, p)| if k == 8 { [0.0; 3] } else { *p }).collect())
        .unwrap();
    for cloth in [one, together] {
        let warnings = said(cloth, 8);
        assert!(matches!(&warnings[..], [Warning::Turns { cloth }] if cloth == "flag"), "{warnings:?}");
    }
    assert_eq!(said(flat(), 8), []);
    let mut free = flat();
    [0, 8].into_iter().for_each(|k| free.set_pinned(k, false).unwrap());
    assert_eq!(Rig::cpu(scene(free), &options(8, 2)).stepper.warnings(), []);
    // 2.5 g on springs of 1 N/m swing in 0.11 s: 1/1920 s is too short a step for them, 1/180 s is not.
    let soft = |soft| {
        let mut cloth = flat();
        cloth.compliance = Compliance::Constant(soft);
        cloth
    };
    let warnings = said(soft(1.0), 32);
    let [Warning::Soft { period, enough, .. }] = &warnings[..] else { panic!("{warnings:?}") };
    assert!((period / 0.1104 - 1.0).abs() < 1e-3 && *enough == 3, "{period} {enough}");
    assert_eq!((said(soft(1.0), 3), said(soft(1e-3), 32)), (Vec::new(), Vec::new()));
    // As many as are enough bring it to rest, by springs alone too.
    let mut rig = Rig::cpu(scene(soft(1.0)), &options(*enough, 0));
    rig.frames(900);
    let fastest = speed(&mut rig);
    assert!(fastest < 1e-3, "{fastest} m/s");
}

#[test]
fn steps_too_long_for_a_fabric_are_named() {
    let said = |substeps| {
        let mut felt = Flat::square("felt", 65).cloth().unwrap();
        felt.set_material(&Material::named("felt").unwrap()).unwrap();
        felt.set_pinned(0, true).unwrap();
        Rig::cpu(scene(felt), &Options { substeps, ..options(1, 2) }).stepper.warnings().to_vec()
    };
    let limp = |warning: &Warning| matches!(warning, Warning::Limp { .. });
    assert!(!said(None).iter().any(limp), "chosen substeps are enough");
    let warnings = said(Some(4));
    let Some(Warning::Limp { softer, enough, .. }) = warnings.iter().find(|w| limp(w)) else { panic!("{warnings:?}") };
    assert!((softer / (f64::from(*enough) / 4.0).powi(2) - 1.0).abs() < 0.2 && *enough > 8, "{softer} {enough}");
    assert!(!said(Some(*enough)).iter().any(limp));
}
