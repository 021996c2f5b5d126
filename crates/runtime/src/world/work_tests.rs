use super::*;
use crate::collider::{Collider, Shape};
use crate::cpu::rows::Threads;
use crate::options::Options;
use crate::quality::Quality;
use crate::scene::{Scene, builtin};

/// Ten seconds on the CPU: mean cost and largest error of the last one, and what a round costs.
fn run(scene: &Scene, options: Options, round: Option<f64>) -> (f64, f64, f64) {
    let mut world = World::new(scene.clone(), options).unwrap();
    let round = world.control.round.or(round).unwrap();
    let (threads, mut bodies) = (Threads::new(1).unwrap(), world.bodies::<f32>());
    let (mut cost, mut error) = (0.0, 0f64);
    for frame in 0..600 {
        world.choose();
        let steps = world.control.clock.frame(1.0 / 60.0).steps;
        world.run(&mut bodies, &threads, steps);
        if frame >= 540 {
            cost += f64::from(steps) * (1.0 + round * f64::from(world.control.options.polish)) / 60.0;
            error = error.max(world.control.chooser.error.unwrap());
        }
    }
    (cost, error, round)
}

#[test]
fn a_mix_costs_no_more_than_substeps_alone() {
    let sheet = builtin("s1", 32).unwrap();
    let quality = Quality::Error(0.02);
    for tethers in [2, 0] {
        let options = Options { quality, tethers, ..Options::default() };
        let (mixed, error, round) = run(&sheet, options.clone(), None);
        let alone = [0, 2, 4].map(|polish| {
            let fixed = Options { polish: Some(polish), ..options.clone() };
            run(&sheet, fixed, Some(round)).0
        });
        eprintln!("{tethers} tethers: {mixed:.1} with {:.2} %, alone {alone:.1?}", 100.0 * error);
        assert!(mixed <= alone[0].min(alone[2]), "{tethers} tethers: {mixed} {alone:?}");
        assert!(error <= 0.02, "{tethers} tethers: {error}");
    }
}

#[test]
fn a_round_costs_what_its_passes_cost() {
    let cost = |scene: &Scene, options: Options| {
        let options = Options { quality: Quality::Error(0.01), ..options };
        World::new(scene.clone(), options).unwrap().control.round
    };
    let mut sheet = builtin("s1", 9).unwrap();
    let default = Options::default();
    // Four colours of springs; a substep has diagonal springs, two tethers three times, and the integration besides.
    let of_sheet = cost(&sheet, default.clone()).unwrap();
    assert!((of_sheet - 4.0 / 18.2).abs() < 1e-9, "{of_sheet}");
    let given = Options { polish: Some(3), ..default.clone() };
    assert_eq!(cost(&sheet, given), None);
    assert_eq!(cost(&sheet, Options { solver: Solver::Classic, ..default.clone() }), None);
    sheet.colliders.push(Collider::new(Shape::Sphere { radius: 0.1 }, [0.0, -3.0, 0.0]));
    // Among colliders each round has tethers.
    let among = cost(&sheet, default.clone()).unwrap();
    assert!((among - 7.4 / 23.4).abs() < 1e-9, "{among}");
    let soft = builtin("s1k", 9).unwrap();
    assert_eq!(cost(&soft, default), None);
}
