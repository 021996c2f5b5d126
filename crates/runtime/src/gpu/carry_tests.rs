use super::super::adapter::device;
use super::*;
use crate::cloth::{Cloth, Flat, Particle, Parts};
use crate::coarser::{Motion, lengths};
use crate::cpu::start::inverse_masses;
use crate::cpu::{prolong, restrict};
use crate::gpu::{Pipelines, read_back};
use crate::options::{Options, Solver};
use crate::scene::Scene;
use crate::world::World;

/// A sheet of `n` columns whose sides are one seam, so it is a tube; the first row is pinned, and one particle between coarse texels.
fn tube(n: u32) -> Cloth {
    let flat = Flat { width: n, height: 17, ..Flat::square("tube", 2) }.cloth().unwrap();
    let next = |k: u32| match k % n {
        0 => Some(k + n - 1),
        column if column == n - 1 => Some(k + 1 - n),
        _ => None,
    };
    let positions = flat.positions().iter().enumerate().map(|(k, p)| {
        let angle = std::f32::consts::TAU * (k as u32 % n % (n - 1)) as f32 / (n - 1) as f32;
        [0.2 * angle.cos(), p[2] * -0.5, 0.2 * angle.sin()]
    });
    let particles = (0..flat.len() as u32).map(|k| Particle::Free { next: next(k) });
    let (grids, rest, mass) = (flat.grids().to_vec(), flat.rest().clone(), crate::Mass::Constant(1e-3));
    let parts = Parts {
        name: "tube".into(),
        grids,
        positions: positions.collect(),
        particles: particles.collect(),
        rest,
        mass,
    };
    let mut cloth = Cloth::new(parts).unwrap();
    (0..n).for_each(|k| cloth.set_pinned(k as usize, true).unwrap());
    cloth.set_pinned((7 * n + 5) as usize, true).unwrap();
    cloth
}

fn sheet(n: u32) -> Cloth {
    let mut cloth = Flat::square("sheet", n).cloth().unwrap();
    [0, n - 1, 9 * n + 3].iter().for_each(|k| cloth.set_pinned(*k as usize, true).unwrap());
    cloth
}

/// A wrinkled motion of a cloth, of which duplicates have the same bits.
fn wrinkled(cloth: &Cloth) -> Motion {
    let points = cloth.points();
    let w = inverse_masses(cloth, Solver::Xpbd);
    let at = |k: usize, ago: f32| {
        let (p, n) = (cloth.positions()[points[k] as usize], points[k] as f32);
        let wave = 0.01 * (n * 1.7).sin() + ago * (n * 0.3).cos();
        [0.9 * p[0] + wave, p[1] - wave, 0.9 * p[2] + 0.5 * wave, w[k]]
    };
    let list = |ago: f32| (0..cloth.len()).map(|k| at(k, ago)).collect();
    Motion { now: list(0.0), before: list(1e-3) }
}

fn farthest(a: &[[f32; 4]], b: &[[f32; 4]]) -> f32 {
    assert_eq!(a.len(), b.len());
    a.iter().zip(b).flat_map(|(p, q)| (0..4).map(move |c| (p[c] - q[c]).abs())).fold(0.0, f32::max)
}

/// A leg of a motion on the device, and where pins then lie beside theirs.
fn on_device(
    handles: &(wgpu::Device, wgpu::Queue),
    gpu: &mut Gpu,
    leg: &Leg,
    motion: &Motion,
) -> (Motion, Vec<[f32; 4]>) {
    let (device, queue) = handles;
    let span = |list: &[[f32; 4]]| -> Span { upload(device, "motion", list, BufferUsages::empty()).into() };
    let beside: Span = upload(device, "beside", &rows(&leg.beside), BufferUsages::empty()).into();
    let mut encoder = device.create_command_encoder(&Default::default());
    let mut pass = begin(&mut encoder, "leg");
    let [now, before] = gpu.leg(&mut pass, leg, &[span(&motion.now), span(&motion.before)], &beside);
    drop(pass);
    queue.submit([encoder.finish()]);
    let read = |span: &Span| read_back(device, queue, span).unwrap();
    (Motion { now: read(&now), before: read(&before) }, read(&beside))
}

#[test]
fn motion_on_the_device_is_that_of_the_twins() {
    let Some(handles) = device() else { return };
    for fine in [sheet(33), sheet(32), sheet(67), tube(33), tube(30)] {
        let name = format!("{} of {}", fine.name(), fine.grids()[0].width);
        let mut scene = Scene::new("level");
        scene.cloths.push(fine.clone());
        let world = World::new(scene, Options::default()).unwrap();
        let pipelines = Pipelines::new(&handles.0, None);
        let mut gpu = Gpu::new(&world, (&handles.0, &handles.1), pipelines, false).unwrap();
        let coarser = fine.coarser().unwrap();
        let (coarse, motion) = (coarser.cloth(), wrinkled(&fine));
        let table = Arc::new(coarser.table(&fine, coarse, Solver::Xpbd));
        let room = |cloth: &Cloth| {
            let now: Vec<_> = inverse_masses(cloth, Solver::Xpbd).into_iter().map(|w| [0.0, 0.0, 0.0, w]).collect();
            Motion { before: now.clone(), now }
        };
        // Ways on the host are those of another place: the device finds its own.
        let beside: Beside = coarser.beside(&fine, &room(&fine));
        assert_eq!(beside.len(), 1, "{name}");

        let weights = inverse_masses(coarse, Solver::Xpbd);
        let down = Leg { down: true, table: table.clone(), inverse_masses: weights, beside };
        let (there, ways) = on_device(&handles, &mut gpu, &down, &motion);
        let (again, _) = on_device(&handles, &mut gpu, &down, &motion);
        assert_eq!((&there.now, &there.before), (&again.now, &again.before), "{name}: bit for bit");
        let mut twin = room(coarse);
        restrict::run(&table, &motion, &mut twin);
        let far = farthest(&there.now, &twin.now).max(farthest(&there.before, &twin.before));
        assert!(far < 2e-6, "{name}: {far} m from the twin");
        let way = coarser.beside(&fine, &motion)[0].2;
        assert!((0..3).all(|c| (ways[1][c] - way[c]).abs() < 1e-6), "{name}: {way:?}, {:?}", ways[1]);
        let sampled: Vec<_> = coarser.samples().iter().map(|k| motion.now[*k as usize]).collect();
        let [short, moved] = [&sampled, &there.now].map(|list| shortage(coarse, list));
        eprintln!("{name}: {far:e} m from the twin; springs are short by {short}, then by {moved}");
        assert!(short > 0.05 && moved < 0.95 * short, "{name}");

        let weights = inverse_masses(&fine, Solver::Xpbd);
        let beside = coarser.beside(&fine, &motion);
        let up = Leg { down: false, table: table.clone(), inverse_masses: weights, beside: beside.clone() };
        let (there, _) = on_device(&handles, &mut gpu, &up, &twin);
        let mut fine_twin = room(&fine);
        prolong::run(&table, &twin, &beside, &mut fine_twin);
        let far = farthest(&there.now, &fine_twin.now).max(farthest(&there.before, &fine_twin.before));
        assert!(far < 1e-6, "{name}: {far} m from the twin");
        // Duplicates have the same bits on both levels.
        for (cloth, list) in [(coarse, &twin.now), (&fine, &there.now)] {
            assert!(cloth.points().iter().enumerate().all(|(k, p)| list[k] == list[*p as usize]), "{name}");
        }
    }
}

/// The mean share of its length at rest that a spring is too short by.
fn shortage(cloth: &Cloth, list: &[[f32; 4]]) -> f64 {
    let points: Vec<usize> = cloth.points().into_iter().map(|k| k as usize).collect();
    let short = lengths(cloth, &points).map(|([a, b], rest)| {
        let long = (0..3).map(|c| f64::from(list[a][c] - list[b][c]).powi(2)).sum::<f64>().sqrt();
        (1.0 - long / rest).max(0.0)
    });
    let all: Vec<f64> = short.collect();
    all.iter().sum::<f64>() / all.len() as f64
}

#[test]
fn a_switch_does_not_wait_for_the_device() {
    let Some((device, queue)) = device() else { return };
    let mut scene = Scene::new("levels");
    scene.cloths = vec![sheet(33), tube(33), sheet(30)];
    let mut stepper = crate::Stepper::new(scene, Options::default(), Some((&device, &queue))).unwrap();
    let waits = || crate::gpu::lost::WAITS.get();
    for level in [1, 0, 2, 1, 0] {
        let before = waits();
        for _ in 0..2 {
            let mut encoder = device.create_command_encoder(&Default::default());
            stepper.record(&mut encoder, 1.0 / 60.0).unwrap();
            queue.submit([encoder.finish()]);
        }
        stepper.set_levels(&[(0.into(), level), (1.into(), level)]).unwrap();
        assert_eq!(waits(), before, "level {level}");
        let states = [0, 1, 2].map(|cloth| stepper.state(cloth).unwrap());
        assert_eq!(waits(), before + 3, "a state is read back");
        assert_eq!(states.map(|state| state.positions().len()), [0, 1, 2].map(|c| stepper.scene().cloths[c].len()));
    }
}
