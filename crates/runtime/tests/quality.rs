//! An error target sets the numbers of substeps and of rounds of polish, and a change does not push the cloth.

use crate::support::rig::{FRAME, Rig};
use crate::support::{self, curtain, scene};
use gimage_runtime::*;

/// Without tethers, so that stretch is the error of relaxation.
fn options(solver: Solver, quality: Quality) -> Options {
    Options { solver, quality, substeps: Some(8), tethers: 0, threads: 1, ..Options::default() }
}

fn damped() -> Scene {
    let mut cloth = curtain(32);
    cloth.damping = 2.0;
    scene(cloth)
}

/// A curtain held aside, and let go.
fn swinging(n: u32, damping: f32) -> Scene {
    let mut cloth = curtain(n);
    cloth.place(cloth.positions().iter().map(|p| [p[0], p[1] * 0.6, -p[1] * 0.8]).collect()).unwrap();
    cloth.damping = damping;
    scene(cloth)
}

fn substeps(rig: &Rig) -> u32 {
    rig.stepper.substeps()
}

fn measured(rig: &Rig) -> Measures {
    let scene = rig.stepper.scene();
    let dt = rig.stepper.options().step / f64::from(substeps(rig));
    measure(&scene.cloths[0], &rig.positions(0), &rig.previous(0), dt, scene.gravity)
}

#[test]
fn a_hanging_flag_is_as_stretched_as_is_asked_for() {
    for solver in [Solver::Classic, Solver::Xpbd] {
        for target in [0.05, 0.01] {
            let mut rig = Rig::cpu(damped(), &options(solver, Quality::Error(target)));
            rig.frames(600);
            let (mut least, mut most) = (u32::MAX, 0);
            let mut error = 0f64;
            for _ in 0..300 {
                rig.frame(FRAME);
                (least, most) = (least.min(substeps(&rig)), most.max(substeps(&rig)));
                error = error.max(measured(&rig).stretch_max);
                let estimate = rig.stepper.estimated_error().unwrap();
                assert!((estimate - measured(&rig).stretch_max).abs() < 0.1 * target);
            }
            eprintln!("{solver:?} {target}: {least} to {most} substeps, stretch {error:.5}");
            assert!(error < 1.05 * target && error > 0.5 * target, "{solver:?} {target}: {error}");
            assert!(most - least <= 1 + most / 8, "{solver:?} {target}: {least} to {most}");
        }
    }
}

#[test]
fn cloth_at_rest_has_fewer_substeps_than_in_motion() {
    let mut rig = Rig::cpu(swinging(32, 1.0), &options(Solver::Xpbd, Quality::Error(0.05)));
    let mut counts = Vec::new();
    for _ in 0..900 {
        rig.frame(FRAME);
        counts.push(substeps(&rig));
    }
    let (moving, rest) = (counts[..120].iter().max().unwrap(), counts[899]);
    eprintln!("{moving} in motion, {rest} at rest");
    assert!(rest * 5 < moving * 4, "{moving} {rest}");
}

#[test]
fn a_change_of_substeps_is_no_push() {
    // In free flight nothing but the velocity goes on.
    let mut cloth = Flat::square("flat", 8).cloth().unwrap();
    cloth.velocity = [1.0, 2.0, -0.5];
    let gravity = [0.0; 3];
    for mut rig in Rig::both(&Scene { gravity, ..scene(cloth) }, &options(Solver::Xpbd, Quality::Fixed)) {
        rig.frame(FRAME);
        let before = measured(&rig).kinetic;
        for substeps in [10, 3, 64, 1, 8] {
            let with = Options { substeps: Some(substeps), ..rig.stepper.options().clone() };
            rig.stepper.set_options(with).unwrap();
            rig.frame(FRAME);
            let change = measured(&rig).kinetic / before - 1.0;
            assert!(change.abs() < 2e-3, "{} {substeps}: {change}", rig.name());
        }
    }
    // In the middle of a swing, by as much as is ever chosen: the same as without, one frame and six frames later.
    for solver in [Solver::Classic, Solver::Xpbd] {
        let start = swinging(20, 0.0);
        let all = [16, 20, 14].map(|to| {
            let change = |mut rig: Rig| {
                rig.frames(20);
                let with = Options { substeps: Some(to), ..rig.stepper.options().clone() };
                rig.stepper.set_options(with).unwrap();
                rig.frame(FRAME);
                let soon = measured(&rig);
                rig.frames(5);
                (rig.name(), soon.kinetic, measured(&rig))
            };
            let fixed = Options { substeps: Some(16), ..options(solver, Quality::Fixed) };
            Rig::both(&start, &fixed).into_iter().map(change).collect::<Vec<_>>()
        });
        for (k, (name, soon, late)) in all.iter().flat_map(|a| a.iter().enumerate()) {
            let (_, base, last) = all[0][k];
            let total = (late.kinetic + late.potential) - (last.kinetic + last.potential);
            eprintln!("{solver:?} {name}: {:.4} % of {base} J, then {total} J", 100.0 * (soon / base - 1.0));
            assert!((soon / base - 1.0).abs() < 0.01, "{solver:?} {name}: {soon} {base}");
            assert!(total.abs() < 0.01 * base, "{solver:?} {name}: {total}");
        }
    }
}

#[test]
fn rounds_change_on_the_cpu_unless_they_are_given() {
    let counts = |polish| {
        let with = Options { polish, quality: Quality::Error(0.05), ..Options::default() };
        let mut rig = Rig::cpu(scene::builtin("s1", 32).unwrap(), &with);
        let frames = (0..600).map(|_| {
            rig.frame(FRAME);
            rig.stepper.polish()
        });
        frames.collect::<Vec<_>>()
    };
    let open = counts(None);
    assert!(open.iter().any(|r| *r != open[0]), "{open:?}");
    assert!(counts(Some(2)).iter().all(|r| *r == 2));
    if let Some(device) = support::device() {
        let mut rig = Rig::gpu(damped(), &options(Solver::Xpbd, Quality::Error(0.02)), &device);
        let compiled = rig.stepper.compiled();
        (0..60).for_each(|_| rig.frame_to_its_end(FRAME));
        assert!(substeps(&rig) > 8 && rig.stepper.polish() == 0);
        assert_eq!(rig.stepper.compiled(), compiled);
    }
}

#[test]
fn cloth_at_rest_stays_at_rest_when_rounds_change() {
    let settled = |polish| {
        let with = Options { polish: Some(polish), tethers: 2, ..options(Solver::Xpbd, Quality::Fixed) };
        let mut rig = Rig::cpu(damped(), &with);
        rig.frames(480);
        rig
    };
    for (from, to) in [(3, 4), (4, 3), (1, 0), (0, 1)] {
        let mut rig = settled(from);
        let with = Options { polish: Some(to), ..rig.stepper.options().clone() };
        rig.stepper.set_options(with).unwrap();
        let mut most = 0f64;
        for _ in 0..60 {
            rig.frame(FRAME);
            most = most.max(measured(&rig).kinetic);
        }
        eprintln!("{from} to {to}: {most} J");
        // A sheet of 0.2 kg at 2 cm/s.
        assert!(most < 0.5 * 0.2 * 0.02 * 0.02, "{from} to {to}: {most} J");
    }
}

#[test]
fn changes_do_not_add_energy() {
    // Up and down again and again, as a target that is nearly met might.
    let energy = |m: Measures| m.kinetic + m.potential;
    for mut rig in Rig::both(&swinging(20, 0.0), &options(Solver::Xpbd, Quality::Fixed)) {
        let (start, mut most) = (energy(measured(&rig)), f64::MIN);
        let depth = 0.2 * 9.81;
        for frame in 0..180 {
            let with = Options { substeps: Some([8, 10][frame / 3 % 2]), ..rig.stepper.options().clone() };
            rig.stepper.set_options(with).unwrap();
            rig.frame(FRAME);
            most = most.max(energy(measured(&rig)));
        }
        eprintln!("{}: {:.3} % at most", rig.name(), 100.0 * (most - start) / depth);
        assert!(most - start < 5e-3 * depth, "{}: {start} {most}", rig.name());
    }
}

#[test]
fn on_the_cpu_every_run_and_any_threads_choose_the_same() {
    let run = |threads| {
        let with = Options { threads, ..options(Solver::Xpbd, Quality::Error(0.02)) };
        let mut rig = Rig::cpu(swinging(160, 0.5), &with);
        let counts: Vec<_> = (0..40)
            .map(|_| {
                rig.frame(FRAME);
                substeps(&rig)
            })
            .collect();
        (counts, rig.positions(0))
    };
    let one = run(1);
    assert!(one.0.iter().any(|n| *n != one.0[0]));
    assert!(one == run(1) && one == run(3));
}

#[test]
fn both_backends_choose_the_same() {
    // A cloth that swings on lets rounding grow to a tenth of the error within 70 frames, and a choice may hang on it; one that comes
    // to rest does not.
    for (damping, same) in [(1.0, 60), (5.0, 120)] {
        for (solver, fused) in [(Solver::Classic, false), (Solver::Xpbd, false), (Solver::Xpbd, true)] {
            // Rounds of polish change on the CPU alone.
            let with = Options { fused, polish: Some(0), ..options(solver, Quality::Error(0.015)) };
            let run = |mut rig: Rig| {
                let mut counts = Vec::new();
                for _ in 0..same {
                    rig.frame_to_its_end(FRAME);
                    counts.push(substeps(&rig));
                }
                (counts, rig.stepper.estimated_error().unwrap())
            };
            let all: Vec<_> = Rig::both(&swinging(20, damping), &with).into_iter().map(run).collect();
            eprintln!("{solver:?} {fused} {damping}: {:?}", all[0]);
            assert!(all[0].0.iter().any(|n| *n != 8));
            for (counts, error) in &all[1..] {
                assert_eq!(*counts, all[0].0, "{solver:?} {fused} {damping}");
                assert!((error - all[0].1).abs() < 1e-3, "{solver:?} {fused} {damping}: {error} {}", all[0].1);
            }
        }
    }
}

#[test]
fn what_cloth_yields_is_no_error() {
    // Converged stretch of springs of 1000 N/m, and of 300 N/m along warp and weft, found with 256 substeps.
    let mut springs = scene::builtin("s1k", 32).unwrap();
    springs.cloths[0].damping = 2.0;
    let mut fabric = damped();
    let material = Material { warp: 300.0, weft: 300.0, shear: 30.0, damping: 2.0, ..Material::default() };
    fabric.cloths[0].set_material(&material).unwrap();
    for (name, scene, truth, target) in [("springs", &springs, 0.0188, 0.01), ("fabric", &fabric, 0.00513, 0.005)] {
        let mut rig = Rig::cpu(scene.clone(), &options(Solver::Xpbd, Quality::Error(target)));
        rig.frames(480);
        let (estimate, error) = (rig.stepper.estimated_error().unwrap(), measured(&rig).stretch_max - truth);
        eprintln!("{name}: {} substeps, estimated {estimate:.5}, error {error:.5}", substeps(&rig));
        assert!(estimate <= target && estimate > 0.5 * target, "{name}: {estimate}");
        assert!(error < estimate && error > 0.2 * estimate, "{name}: {error} {estimate}");
    }
}

#[test]
fn soft_cloth_is_measured_alike_on_both_backends() {
    // Falling cloth is not stretched yet.
    for (name, scene) in support::soft().into_iter().filter(|s| !s.0.contains("collider")) {
        for fused in [false, true] {
            let with = Options { fused, ..options(Solver::Xpbd, Quality::Error(1e-4)) };
            let run = |mut rig: Rig| {
                (0..3).for_each(|_| rig.frame_to_its_end(FRAME));
                rig.stepper.estimated_error().unwrap()
            };
            let all: Vec<_> = Rig::both(&scene, &with).into_iter().map(run).collect();
            eprintln!("{name} {fused}: {all:?}");
            assert!(all[0] > 0.0);
            assert!(all.iter().all(|e| (e / all[0] - 1.0).abs() < 1e-3), "{name} {fused}: {all:?}");
        }
    }
}

#[test]
fn every_grid_counts_and_springs_between_pins_do_not() {
    // A spring of each grid in turn is twice as long as it should be.
    for solver in [Solver::Classic, Solver::Xpbd] {
        let cloth = support::two_charts(9);
        for long in [10, 9 * 9 + 40] {
            let mut held = cloth.clone();
            (0..held.len()).for_each(|k| held.set_pinned(k, k != long).unwrap());
            let mut at = held.positions().to_vec();
            at[long][2] += 1.0;
            held.place(at).unwrap();
            held.set_pinned(long, true).unwrap();
            let with = options(solver, Quality::Error(0.1));
            for mut rig in Rig::both(&scene(held), &with) {
                rig.frame_to_its_end(FRAME);
                rig.frame_to_its_end(FRAME);
                // Everything is pinned: nothing can be relaxed.
                assert_eq!(rig.stepper.estimated_error(), Some(0.0), "{} {long}", rig.name());
                rig.stepper.set_pinned(0, if long < 81 { long + 1 } else { long - 1 }, false).unwrap();
                rig.frame_to_its_end(FRAME);
                rig.frame_to_its_end(FRAME);
                let error = rig.stepper.estimated_error().unwrap();
                assert!(error > 1.0, "{} {long}: {error}", rig.name());
            }
        }
    }
}

#[test]
fn only_what_asks_for_it_pays() {
    let plan = |quality| Rig::cpu(damped(), &options(Solver::Xpbd, quality)).stepper.plan();
    let (fixed, budget, error) = (plan(Quality::Fixed), plan(Quality::Budget(2.0)), plan(Quality::Error(0.01)));
    assert_eq!(fixed, budget);
    assert!(fixed.passes.iter().all(|p| p.shader != "strain"));
    assert_eq!((error.dispatches(), error.bytes()), (fixed.dispatches() + 1, fixed.bytes() + 4));
}

#[test]
fn a_budget_needs_a_clock_and_keeps_to_it() {
    for mut rig in Rig::both(&damped(), &options(Solver::Xpbd, Quality::Budget(3.0))) {
        rig.frames(10);
        assert_eq!(substeps(&rig), 8, "{}", rig.name());
        for _ in 0..120 {
            // A host on which a step takes 0.25 ms.
            let steps = substeps(&rig);
            rig.frame(FRAME);
            rig.stepper.took(steps, 0.25 * f64::from(steps));
        }
        assert!((11..=12).contains(&substeps(&rig)), "{}: {}", rig.name(), substeps(&rig));
    }
}
