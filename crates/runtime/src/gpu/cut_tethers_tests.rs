use super::super::adapter::device;
use super::*;
use crate::choose::Hold;
use crate::cloth::{Flat, Particle, Parts};
use crate::cpu::rows::Threads;
use crate::gpu::Pipelines;
use crate::options::{Options, Solver};
use crate::scene::Scene;
use crate::world::images::Images;
use crate::world::{Action, ClothRun};

/// A tube whose first and last column are one, and whose first row is pinned here and there.
fn tube(n: u32, rows: u32, pins: &[u32]) -> Cloth {
    let (mut positions, mut particles) = (Vec::new(), Vec::new());
    for (j, i) in (0..rows).flat_map(|j| (0..n).map(move |i| (j, i))) {
        let angle = std::f32::consts::TAU * (i % (n - 1)) as f32 / (n - 1) as f32;
        positions.push([0.2 * angle.cos(), -0.05 * j as f32, 0.2 * angle.sin()]);
        let next = (i % (n - 1) == 0).then_some(j * n + n - 1 - i);
        particles.push(Particle::Free { next });
    }
    let (x, y) = (0.2 * std::f32::consts::TAU / (n - 1) as f32, 0.05);
    let grid = crate::Grid { name: "tube".into(), first: 0, width: n, height: rows };
    let rest = Rest::Constant(vec![[x, y, x.hypot(y), x.hypot(y)]]);
    let mass = crate::Mass::Constant(1e-3);
    let parts = Parts { name: "tube".into(), grids: vec![grid], positions, particles, rest, mass };
    let mut cloth = Cloth::new(parts).unwrap();
    pins.iter().for_each(|k| cloth.set_pinned(*k as usize, true).unwrap());
    cloth
}

/// A curtain on two pins, of two pieces that overlap by a row and are sewn there by threads of 1 mm, each of its stitches between columns.
fn sewn(n: u32) -> Cloth {
    let d = 1.0 / (n - 1) as f32;
    let (mut positions, mut stitches) = (Vec::new(), Vec::new());
    for k in 0..2 * n * n {
        let (sheet, i, j) = ((k / (n * n)) as f32, k % n, k % (n * n) / n);
        let [u, v] = [i as f32 * d + 0.3 * sheet * d, 1.0 - 0.6 * d];
        positions.push([0.9 * u, -0.5 * (j as f32 * d + sheet * v), 1e-3 * sheet]);
        if k >= n * n && j == 0 && i + 1 < n {
            stitches.push(crate::Stitch { particle: k, piece: 0, at: [u, v], distance: 1e-3 });
        }
    }
    let [x, y] = [0.9 * d, 0.5 * d];
    let grid = |g: u32| crate::Grid { name: g.to_string(), first: g * n * n, width: n, height: n };
    let rest = Rest::Constant(vec![[x, y, x.hypot(y), x.hypot(y)]; 2]);
    let particles = vec![Particle::Free { next: None }; positions.len()];
    let (grids, mass) = (vec![grid(0), grid(1)], crate::Mass::Constant(1e-3));
    let parts = Parts { name: "sewn".into(), grids, positions, particles, rest, mass };
    let mut cloth = Cloth::new(parts).unwrap();
    [0, n - 1].iter().for_each(|k| cloth.set_pinned(*k as usize, true).unwrap());
    cloth.set_stitches(stitches).unwrap();
    cloth
}

fn hung(n: u32, pins: &[usize]) -> Cloth {
    let mut cloth = Flat { down: [0.0, -1.0, 0.0], ..Flat::square("flat", n) }.cloth().unwrap();
    pins.iter().for_each(|k| cloth.set_pinned(*k, true).unwrap());
    cloth
}

/// Anchors and distances of every cloth after each of some cuts.
fn followed(
    cloths: &[Cloth],
    cuts: &[[[f32; 3]; 3]],
    gpu: Option<&(wgpu::Device, wgpu::Queue)>,
) -> Vec<Vec<(u32, f32)>> {
    let mut scene = Scene::new("cut");
    scene.cloths = cloths.to_vec();
    let mut world = World::new(scene, Options { solver: Solver::Xpbd, tethers: 2, ..Options::default() }).unwrap();
    // A software adapter ends loops early.
    gpu.iter().for_each(|(device, _)| world.make_room(crate::fused::Room::of(device)));
    let mut bodies = world.bodies::<f32>();
    let mut there =
        gpu.map(|(device, queue)| Gpu::new(&world, (device, queue), Pipelines::new(device, None), false).unwrap());
    world.scene.cloths.iter_mut().for_each(Cloth::open);
    world.reschedule();
    let mut all = Vec::new();
    match (&mut there, gpu) {
        (Some(there), Some((device, queue))) => {
            there.open(&world);
            for cut in cuts {
                world.host.actions.push(Action::Cut { corners: *cut, spared: Vec::new() });
                let mut encoder = device.create_command_encoder(&Default::default());
                there.act_now(&mut world, &mut encoder);
                queue.submit([encoder.finish()]);
                for buffers in &there.cloths {
                    let tethers = buffers.other(Slot::Tethers).unwrap().clone().into();
                    let words = super::super::read_back_u32(device, queue, &tethers).unwrap();
                    all.push(words.chunks(2).map(|w| (w[0], f32::from_bits(w[1]))).collect());
                }
            }
        }
        _ => {
            let each = bodies.iter_mut().zip(world.scene.cloths.iter().zip(&world.runs));
            each.for_each(|(body, (cloth, held))| body.open(cloth, &held.tethers));
            for cut in cuts {
                world.host.actions.push(Action::Cut { corners: *cut, spared: Vec::new() });
                world.act(&mut bodies, &Threads::one());
                for held in bodies.iter().map(|b| b.held.as_ref().unwrap()) {
                    all.push(held.anchors.iter().copied().zip(held.most.iter().copied()).collect());
                }
            }
        }
    }
    all
}

#[test]
fn a_cut_takes_few_dispatches_whatever_the_size_of_the_cloth() {
    for (n, most) in [(16, 6), (64, 10), (256, 84), (1000, 132)] {
        let cloth = hung(n, &[0, n as usize - 1]);
        let images = Images::of(&mut cloth.clone(), cloth.clone(), Hold { most: 2, slack: 1.0 }, [].into_iter());
        let run = ClothRun::new(images);
        // A device, and one that ends loops early.
        let walks = [u32::MAX, 65_535 / 4].map(|loops| Walk::new(&cloth, &run.tethers, loops).dispatches());
        let counts = walks.map(|list| list.len());
        assert!(counts[0] == 6 && counts[1] <= most, "{n}: {counts:?}");
    }
}

#[test]
fn tethers_after_cuts_are_those_of_the_twin() {
    let Some(gpu) = device() else { return };
    let cloths = [
        hung(24, &[0, 23]),
        hung(17, &[8]),
        hung(20, &(0..20).collect::<Vec<_>>()),
        hung(21, &[2, 3, 4, 200, 221, 17]),
        tube(17, 20, &[0]),
        tube(13, 18, &[3, 4, 5, 9]),
        // Long ways, in walks of several dispatches where a device ends loops early.
        hung(150, &[0, 149]),
        sewn(16),
    ];
    let cuts = [
        [[0.3, -0.3, 3.0], [-0.6, -0.35, -2.0], [0.9, -0.28, -2.0]],
        [[0.5, 0.3, 3.0], [0.52, -0.7, -2.0], [0.51, -0.1, -2.0]],
        // Right through.
        [[0.45, -0.603, 3.0], [-4.0, -0.602, -2.0], [4.9, -0.601, -2.1]],
    ];
    let (here, there) = (followed(&cloths, &cuts, None), followed(&cloths, &cuts, Some(&gpu)));
    assert_eq!((here.len(), there.len()), (24, 24));
    let (mut other, mut all, mut ended) = (0, 0, 0);
    for (n, (here, there)) in here.iter().zip(&there).enumerate() {
        for (t, (a, b)) in here.iter().zip(there).enumerate().filter(|(_, (a, _))| a.0 != u32::MAX) {
            let (cloth, cut) = (n % 8, n / 8);
            assert!((a.1 - b.1).abs() <= 1e-5 * a.1, "cloth {cloth}, cut {cut}, tether {t}: {a:?} {b:?}");
            // Of two pins as near, rounding chooses.
            (other, all) = (other + u32::from(a.0 != b.0), all + 1);
            ended += u32::from(a.1 == f32::MAX);
        }
    }
    assert!(other * 100 < all && ended > 500, "{other} of {all}, {ended} ended");
    // Once more: the same bits.
    let again = followed(&cloths, &cuts, Some(&gpu));
    let bits = |list: &[Vec<(u32, f32)>]| list.iter().flatten().map(|t| (t.0, t.1.to_bits())).collect::<Vec<_>>();
    assert!(bits(&again) == bits(&there));
}
