//! The classic solver on the CPU.

use crate::support::{self, FRAME, compared, is_exact, measured, scene};
use gimage_runtime::*;

fn cpu(scene: Scene, substeps: u32, threads: usize) -> Stepper {
    let options = Options {
        backend: Backend::Cpu,
        substeps: Some(substeps),
        threads,
        solver: Solver::Classic,
        ..Options::default()
    };
    Stepper::on_cpu(scene, options).unwrap()
}

#[test]
fn any_number_of_threads_gives_the_same_bits() {
    // Large enough to be shared out.
    let mut large = support::on_colliders(200);
    large.wind = Some(support::wind(true));
    let run = |threads| {
        let mut stepper = cpu(large.clone(), 2, threads);
        (0..10).for_each(|_| assert_eq!(stepper.advance(FRAME).unwrap().steps, 2));
        let bits = |list: &[[f32; 4]]| list.iter().map(|v| v.map(f32::to_bits)).collect::<Vec<_>>();
        (bits(stepper.positions(0).unwrap()), bits(stepper.normals(0).unwrap()))
    };
    let one = run(1);
    assert!(one == run(2) && one == run(5) && one == run(0));
}

#[test]
fn the_error_of_f32_is_small() {
    for (name, scene) in compared() {
        is_exact(name, scene, Options { solver: Solver::Classic, ..Options::default() });
    }
}

#[test]
fn substeps_and_iterations_cost_what_they_are_known_to() {
    // N = 32 after ten seconds: 8 substeps 32 % / 1.5 %.
    let mut stepper = cpu(scene::builtin("s1", 32).unwrap(), 8, 1);
    (0..600).for_each(|_| assert!(stepper.advance(FRAME).is_ok()));
    let m = measured(&stepper);
    assert!((0.30..0.34).contains(&m.stretch_max) && (0.014..0.016).contains(&m.stretch_mean), "{m:?}");
}

#[test]
fn a_hanging_sheet_swings_in_its_period() {
    // N = 32, 16 substeps: the discrete chain's 1.68170 s and a tenth of a percent.
    let period = support::swing_period(cpu(scene::builtin("s3", 32).unwrap(), 16, 1));
    assert!((period / 1.68170 - 1.0).abs() < 2e-3, "{period}");
}

#[test]
fn damping_does_not_depend_on_the_step() {
    // Free flight without gravity: after a second exp(-2) of the velocity is left.
    for substeps in [1, 4, 16] {
        let mut cloth = Flat::square("flat", 2).cloth().unwrap();
        (cloth.velocity, cloth.damping) = ([1.0, 0.0, 0.0], 2.0);
        let options = Options { substeps: Some(substeps), solver: Solver::Classic, ..Options::default() };
        let mut flight = Reference::new(Scene { gravity: [0.0; 3], ..scene(cloth) }, options).unwrap();
        flight.step(60 * substeps);
        let (now, before) = flight.positions(0).unwrap();
        let speed = (now[0][0] - before[0][0]) * 60.0 * f64::from(substeps);
        assert!((speed - (-2.0f64).exp()).abs() < 1e-6, "{substeps}: {speed}");
        // The path is (1 - exp(-2)) / 2, up to the first order in the step.
        let path = (1.0 - (-2.0f64).exp()) / 2.0;
        assert!((now[0][0] - path).abs() < 0.02 / f64::from(substeps), "{substeps}: {}", now[0][0]);
    }
}

#[test]
fn a_change_of_the_step_keeps_the_velocity() {
    let mut cloth = Flat::square("flat", 2).cloth().unwrap();
    cloth.velocity = [1.0, 0.0, 0.0];
    let mut stepper = cpu(Scene { gravity: [0.0; 3], ..scene(cloth) }, 2, 1);
    for substeps in [2, 7, 3, 1] {
        stepper.set_options(Options { substeps: Some(substeps), ..stepper.options().clone() }).unwrap();
        stepper.advance(FRAME).unwrap();
    }
    let x = stepper.positions(0).unwrap()[0][0];
    assert!((x - 4.0 / 60.0).abs() < 1e-5, "{x}");
}

#[test]
fn a_jump_above_the_speed_limit_is_no_velocity() {
    let mut cloth = Flat::square("flat", 2).cloth().unwrap();
    (cloth.velocity, cloth.speed_limit) = ([3.0, 0.0, 0.0], 2.0);
    let mut stepper = cpu(Scene { gravity: [0.0; 3], ..scene(cloth) }, 1, 1);
    stepper.advance(FRAME).unwrap();
    assert_eq!(stepper.positions(0).unwrap()[0][0], 0.0);
}

#[test]
fn uniform_wind_takes_cloth_along() {
    let cloth = Flat::square("flat", 4).cloth().unwrap();
    let force = WindForce::Push { response: 5.0 };
    let wind = Some(Wind { velocity: [2.0, 0.0, 0.0], gust: 0.0, gust_size: 1.0, force });
    let mut stepper = cpu(Scene { gravity: [0.0; 3], wind, ..scene(cloth) }, 8, 1);
    (0..180).for_each(|_| assert!(stepper.advance(FRAME).is_ok()));
    let speed = (stepper.positions(0).unwrap()[5][0] - stepper.previous(0).unwrap()[5][0]) * 480.0;
    assert!((speed - 2.0).abs() < 1e-2, "{speed}");
}

#[test]
fn drag_of_a_plate_across_the_wind_is_that_of_its_area() {
    // 1 m^2 and 0.2 kg across 3 m/s: a = 0.5 * 1.2 * 9 / 0.2 = 27 m/s^2; along the wind there is none.
    for (down, expected) in [([0.0, 1.0, 0.0], 27.0), ([0.0, 0.0, 1.0], 0.0)] {
        let cloth = Flat { down, ..Flat::square("plate", 9) }.cloth().unwrap();
        let force = WindForce::Triangles { density: 1.2, drag: 1.0, lift: 0.7 };
        let wind = Some(Wind { velocity: [0.0, 0.0, 3.0], gust: 0.0, gust_size: 1.0, force });
        let gravity = [0.0; 3];
        let mut stepper = cpu(Scene { gravity, wind, ..scene(cloth) }, 16, 1);
        let start = measured(&stepper).center;
        stepper.set_options(Options { step: FRAME / 16.0, substeps: Some(1), ..stepper.options().clone() }).unwrap();
        stepper.advance(FRAME / 16.0).unwrap();
        let end = measured(&stepper).center;
        let a = (end[2] - start[2]) / (FRAME / 16.0).powi(2);
        assert!((a - expected).abs() < 0.1, "{a}");
    }
}

#[test]
fn masses_share_out_a_spring() {
    let grid = Grid { name: "two".into(), first: 0, width: 2, height: 2 };
    let cloth = Cloth::new(Parts {
        name: "two".into(),
        grids: vec![grid],
        positions: vec![[0.0; 3], [2.0, 0.0, 0.0], [0.0; 3], [5.0, 0.0, 0.0]],
        particles: vec![
            Particle::Free { next: None },
            Particle::Free { next: None },
            Particle::Pinned { next: None },
            Particle::None,
        ],
        rest: Rest::Constant(vec![[1.0, 0.0, 0.0, 0.0]]),
        mass: Mass::Image(vec![1.0, 3.0, 1.0, 1.0]),
    });
    let mut stepper = cpu(Scene { gravity: [0.0; 3], ..scene(cloth.unwrap()) }, 1, 1);
    stepper.advance(FRAME).unwrap();
    let x: Vec<f32> = stepper.positions(0).unwrap().iter().map(|p| p[0]).collect();
    assert_eq!(x, [0.75, 1.75, 0.0, 5.0]);
}

#[test]
fn friction_holds_on_a_slope_and_a_smooth_one_lets_go() {
    // A slope that falls towards +x by 0.2 rad, whose tangent is 0.203.
    let angle = 0.2f32;
    let (s, c) = (0.5 * angle).sin_cos();
    let right = [angle.cos(), -angle.sin(), 0.0];
    for (friction, holds) in [(0.0, false), (0.1, false), (0.3, true)] {
        let plane = Collider::new(Shape::HalfSpace, [0.0; 3]);
        let plane = Collider { rotation: [0.0, 0.0, -s, c], friction, ..plane };
        let cloth = Flat { right, ..Flat::square("flat", 5) }.cloth().unwrap();
        let mut stepper = cpu(Scene { colliders: vec![plane], ..scene(cloth) }, 8, 1);
        (0..60).for_each(|_| assert!(stepper.advance(FRAME).is_ok()));
        let slid = stepper.positions(0).unwrap()[12][0] - 0.5 * angle.cos();
        assert_eq!(slid < 0.01, holds, "{friction}: {slid}");
    }
}

#[test]
fn nothing_is_left_inside_a_collider_and_seams_stay_closed() {
    for fold in [2, 3, 4] {
        let cloth = support::hung_tube(fold);
        let rings: Vec<Vec<u32>> = (0..cloth.len() as u32).filter_map(|k| Some(cloth.ring_of(k)?.to_vec())).collect();
        let sphere = Collider { friction: 0.3, ..Collider::new(Shape::Sphere { radius: 0.25 }, [0.05, -0.4, 0.0]) };
        let mut stepper = cpu(Scene { colliders: vec![sphere], ..scene(cloth) }, 4, 1);
        for _ in 0..600 {
            stepper.advance(FRAME).unwrap();
            let now = stepper.positions(0).unwrap();
            assert!(rings.iter().all(|r| r.iter().all(|k| now[*k as usize] == now[r[0] as usize])));
        }
        let inside = |p: &[f32; 4]| (p[0] - 0.05).powi(2) + (p[1] + 0.4).powi(2) + p[2].powi(2) < 0.2499f32.powi(2);
        assert!(!stepper.positions(0).unwrap().iter().any(inside));
    }
}

fn without_springs(cloth: &Cloth) -> Cloth {
    let (grids, positions, particles) =
        (cloth.grids().to_vec(), cloth.positions().to_vec(), cloth.particles().to_vec());
    let (name, rest, mass) = ("bare".into(), Rest::None, Mass::Constant(1.0));
    Cloth::new(Parts { name, grids, positions, particles, rest, mass }).unwrap()
}

#[test]
fn normals_are_unit_and_closed_over_seams() {
    let mut stepper = cpu(Scene { gravity: [0.0; 3], ..scene(without_springs(&support::tube(33, 9, 1))) }, 1, 1);
    stepper.advance(FRAME).unwrap();
    let (now, normals) = (stepper.positions(0).unwrap(), stepper.normals(0).unwrap());
    for k in 0..33 * 9 {
        let (p, n) = (now[k], normals[k]);
        let radial = (p[0] * n[0] + p[2] * n[2]) / (p[0] * p[0] + p[2] * p[2]).sqrt();
        assert!(radial.abs() > 0.98 && (n[0] * n[0] + n[1] * n[1] + n[2] * n[2] - 1.0).abs() < 1e-5, "{k}: {n:?}");
    }
}

#[test]
fn cloth_has_normals_before_its_first_frame() {
    let start = |normals| {
        let options = Options { backend: Backend::Cpu, normals, solver: Solver::Classic, ..Options::default() };
        Stepper::on_cpu(scene::builtin("s1", 16).unwrap(), options).unwrap()
    };
    let length = |n: &[f32; 4]| n[..3].iter().map(|x| x * x).sum::<f32>().sqrt();
    let with = start(true);
    assert!(with.normals(0).unwrap().iter().all(|n| (length(n) - 1.0).abs() < 1e-6 && n[1].abs() > 0.999));
    assert!(start(false).normals(0).unwrap().iter().all(|n| *n == [0.0; 4]));
}
