//! The GPU against its twin. Without an adapter each test says that it was skipped; GIMAGE_REQUIRE_GPU=1 makes that a
//! failure.

mod support;

use gimage_runtime::*;
use support::{compared, device};

const FRAME: f64 = 1.0 / 60.0;

const SOLVERS: [Solver; 2] = [Solver::Classic, Solver::Xpbd];

/// All scenes for the classic solver, then for XPBD, with soft springs too.
fn solved() -> Vec<(Solver, &'static str, Scene)> {
    let of =
        |solver, list: Vec<(&'static str, Scene)>| list.into_iter().map(move |(name, scene)| (solver, name, scene));
    of(Solver::Classic, compared()).chain(of(Solver::Xpbd, [support::outside(), support::soft()].concat())).collect()
}

type Lists = [Vec<[f32; 4]>; 3];

fn on_gpu(scene: Scene, options: &Options, gpu: &(wgpu::Device, wgpu::Queue), frames: u32) -> Lists {
    let (device, queue) = gpu;
    let mut stepper = Stepper::new(scene, options.clone(), Some((device, queue))).unwrap();
    for _ in 0..frames {
        let mut encoder = device.create_command_encoder(&Default::default());
        stepper.record(&mut encoder, FRAME).unwrap();
        queue.submit([encoder.finish()]);
    }
    let buffers = stepper.buffers(0).unwrap();
    [&buffers.now, &buffers.before, &buffers.normals].map(|b| read_back(device, queue, b).unwrap())
}

fn on_cpu(scene: Scene, options: &Options, frames: u32) -> Lists {
    let options = Options { backend: Backend::Cpu, ..options.clone() };
    let mut stepper = Stepper::new(scene, options, None).unwrap();
    (0..frames).for_each(|_| assert!(stepper.advance(FRAME).is_ok()));
    [stepper.positions(0), stepper.previous(0), stepper.normals(0)].map(|list| list.unwrap().to_vec())
}

fn largest(a: &[[f32; 4]], b: &[[f32; 4]]) -> f32 {
    let difference = |(a, b): (&[f32; 4], &[f32; 4])| (0..3).map(|c| (a[c] - b[c]).abs()).fold(0.0, f32::max);
    a.iter().zip(b).map(difference).fold(0.0, f32::max)
}

#[test]
fn one_step_is_that_of_the_twin() {
    let Some(gpu) = device() else { return };
    for (solver, name, scene) in solved() {
        let options =
            Options { solver, substeps: 1, iterations: 2, step: FRAME / 8.0, max_catch_up: 1, ..Options::default() };
        let there = on_gpu(scene.clone(), &options, &gpu, 1);
        let here = on_cpu(scene, &options, 1);
        let difference = largest(&there[0], &here[0]);
        eprintln!("{name}: {difference:e} m");
        assert!(difference <= 1e-6, "{name}: {difference:e} m");
        assert!(largest(&there[1], &here[1]) <= 1e-6, "{name}: previous positions");
        assert!(largest(&there[2], &here[2]) <= 2e-3, "{name}: normals {:e}", largest(&there[2], &here[2]));
        assert!(there[0].iter().zip(&here[0]).all(|(a, b)| a[3] == b[3]), "{name}: inverse masses");
    }
}

#[test]
fn after_100_steps_the_measures_agree() {
    let Some(gpu) = device() else { return };
    for (solver, name, scene) in solved() {
        let options = Options { solver, substeps: 10, ..Options::default() };
        let cloth = &scene.cloths[0];
        let of = |lists: Lists| measure(cloth, &lists[0], &lists[1], FRAME / 10.0, scene.gravity);
        let there = of(on_gpu(scene.clone(), &options, &gpu, 10));
        let here = of(on_cpu(scene.clone(), &options, 10));
        let near = |a: f64, b: f64| (a - b).abs() <= 1e-3 * a.abs().max(b.abs());
        assert!(near(there.stretch_max, here.stretch_max), "{name}: {there:?} {here:?}");
        assert!(near(there.stretch_mean, here.stretch_mean), "{name}: {there:?} {here:?}");
        // Against the sum of both kinds: where the potential is 0 is arbitrary, and they may cancel.
        let change = there.kinetic + there.potential - here.kinetic - here.potential;
        let energy = here.kinetic + here.potential.abs();
        assert!(change.abs() <= 1e-3 * energy, "{name}: {there:?} {here:?}");
        // A coordinate near 0 is measured against the size of the cloth.
        let centre = (0..3).all(|c| (there.center[c] - here.center[c]).abs() <= 1e-3);
        assert!(centre, "{name}: {there:?} {here:?}");
    }
}

#[test]
fn two_runs_give_the_same_bits() {
    let Some(gpu) = device() else { return };
    let bits = |lists: Lists| lists.map(|l| l.iter().map(|v| v.map(f32::to_bits)).collect::<Vec<_>>());
    for (solver, name, scene) in solved() {
        let options = Options { solver, iterations: 2, ..Options::default() };
        let run = || bits(on_gpu(scene.clone(), &options, &gpu, 20));
        assert!(run() == run(), "{name}");
    }
}

#[test]
fn seams_stay_closed_for_ten_seconds() {
    let Some(gpu) = device() else { return };
    for (fold, solver) in [2, 3, 4].into_iter().flat_map(|fold| SOLVERS.map(|solver| (fold, solver))) {
        let cloth = support::hung_tube(fold);
        let rings: Vec<Vec<u32>> = (0..cloth.len() as u32).filter_map(|k| Some(cloth.ring_of(k)?.to_vec())).collect();
        let scene = Scene { colliders: support::below(), ..support::scene(cloth) };
        let [now, before, normals] = on_gpu(scene, &Options { solver, substeps: 4, ..Options::default() }, &gpu, 600);
        for list in [now, before, normals] {
            for ring in &rings {
                assert!(ring.iter().all(|k| list[*k as usize] == list[ring[0] as usize]), "ring of {fold}");
            }
            assert!(list.as_flattened().iter().all(|x| x.is_finite()));
        }
    }
}

#[test]
fn changes_reach_the_device() {
    let Some((device, queue)) = device() else { return };
    let run = |backend, solver| {
        let options = Options { solver, substeps: 4, ..Options::default() };
        let options = Options { backend, ..options.clone() };
        let mut stepper = Stepper::new(support::on_colliders(16), options, Some((&device, &queue))).unwrap();
        let mut colliders = support::all_colliders();
        for frame in 0..12 {
            match frame {
                2 => stepper.set_pinned(0, 17, true).unwrap(),
                3 => stepper.set_position(0, 17, [0.1, 0.2, 0.1]).unwrap(),
                4 => colliders[1].center[1] += 0.1,
                5 => drop(colliders.pop()),
                6 => stepper.set_wind(Some(support::wind(true))).unwrap(),
                8 => stepper.set_pinned(0, 17, false).unwrap(),
                9 => stepper.set_options(Options { substeps: 6, ..options_of(&stepper) }).unwrap(),
                10 => stepper.set_asleep(0, true).unwrap(),
                11 => stepper.set_gravity([0.0, -5.0, 1.0]).unwrap(),
                _ => {}
            }
            if frame == 4 || frame == 5 {
                stepper.set_colliders(colliders.clone()).unwrap();
            }
            let mut encoder = device.create_command_encoder(&Default::default());
            stepper.record(&mut encoder, FRAME).unwrap();
            queue.submit([encoder.finish()]);
        }
        assert_eq!(stepper.backend(), backend);
        read_back(&device, &queue, &stepper.buffers(0).unwrap().now).unwrap()
    };
    for solver in SOLVERS {
        let (there, here) = (run(Backend::Gpu, solver), run(Backend::Cpu, solver));
        assert!(largest(&there, &here) < 1e-4, "{solver:?}: {}", largest(&there, &here));
    }
}

fn options_of(stepper: &Stepper) -> Options {
    stepper.options().clone()
}
