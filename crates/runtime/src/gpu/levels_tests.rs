use crate::cloth::Flat;
use crate::gpu::adapter::device;
use crate::gpu::{Gpu, Pipelines, read_back};
use crate::options::Options;
use crate::passes::Pass;
use crate::scene::Scene;
use crate::world::World;

#[test]
fn tiles_of_nodes_give_the_bits_of_one_workgroup() {
    let Some((device, queue)) = device() else { return };
    for [width, height] in [[133, 133], [70, 150], [5, 900]] {
        let (right, down) = ([1.0, 0.0, 0.0], [0.0, -1.0, 0.0]);
        let mut cloth = Flat { width, height, right, down, ..Flat::square("sheet", 2) }.cloth().unwrap();
        // Stretched here and there, so that limits act.
        let place = |(k, p): (usize, &[f32; 3])| {
            let far = 1.0 + 0.1 * ((k * 7919) % 13) as f32 / 13.0;
            [p[0] * far, p[1] * 1.2, 0.02 * ((k * 104_729) % 17) as f32]
        };
        cloth.place(cloth.positions().iter().enumerate().map(place).collect()).unwrap();
        cloth.set_pinned(0, true).unwrap();
        let mut scene = Scene::new("levels");
        scene.cloths.push(cloth);
        let options = Options { substeps: Some(2), pyramid: 1, tethers: 0, ..Options::default() };
        let run = |one: bool| {
            let mut world = World::new(scene.clone(), options.clone()).unwrap();
            let coarse = &mut world.runs[0].schedule.coarse;
            assert!(coarse.iter().any(|p| matches!(p, Pass::CoarseLevel { .. })), "{width} x {height}");
            if one {
                coarse.retain(|p| !matches!(p, Pass::CoarseLevel { .. }));
                let all = |p: &mut Pass| {
                    if let Pass::Pyramid { finest, .. } = p {
                        *finest = 1;
                    }
                };
                coarse.iter_mut().for_each(all);
            }
            let mut gpu = Gpu::new(&world, (&device, &queue), Pipelines::new(&device, None), false).unwrap();
            let mut encoder = device.create_command_encoder(&Default::default());
            gpu.begin(&world, 2);
            gpu.record(&mut world, &mut encoder, 2);
            gpu.flush();
            queue.submit([encoder.finish()]);
            let buffers = gpu.buffers(0).unwrap();
            [&buffers.now, &buffers.before].map(|span| read_back(&device, &queue, span).unwrap())
        };
        let (tiles, one) = (run(false), run(true));
        let moved = tiles[0].iter().zip(scene.cloths[0].positions()).any(|(p, q)| (p[0] - q[0]).abs() > 1e-3);
        assert!(moved, "{width} x {height}: limits act");
        assert!(tiles == one, "{width} x {height}");
    }
}
