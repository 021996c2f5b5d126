//! Meshes that are bound to a cloth as it changes its level: at rest where the source has them, and without a jump in motion.

use crate::support::bound_mesh::{bundle, flag_texel, spread, tube_texel};
use gimage_bundle::Bundle;
use gimage_runtime::*;

const FRAME: f64 = 1.0 / 60.0;
const COUNT: usize = 800;

/// A flag of 33 x 25 texels, 0.4 m wide.
fn flag() -> Bundle {
    let at = |i: u32, j: u32| {
        let [x, y, z, w] = flag_texel(i, j);
        [x / 4.0, y / 4.0, z, w]
    };
    bundle((33, 25), at, &spread(COUNT))
}

fn tube() -> Bundle {
    bundle((13, 9), tube_texel, &spread(COUNT))
}

fn scene(bundle: &Bundle, gravity: f32) -> Scene {
    let mut scene = Scene::new("levels");
    let mut cloth = Cloth::from_bundle("cloth", bundle).unwrap();
    cloth.damping = 0.5;
    scene.cloths.push(cloth);
    scene.gravity = [0.6 * gravity, -gravity, 0.9 * gravity];
    scene
}

fn options() -> Options {
    Options { substeps: Some(6), threads: 1, ..Options::default() }
}

fn gap(a: &[f32; 4], b: &[f32; 4]) -> f32 {
    a.iter().zip(b).map(|(a, b)| (a - b).powi(2)).sum::<f32>().sqrt()
}

/// The largest way of a vertex, and the largest turn of a normal or a tangent.
fn far(a: &[RenderVertex], b: &[RenderVertex]) -> (f32, f32) {
    let each = a.iter().zip(b);
    let turn = |(a, b): (&RenderVertex, &RenderVertex)| gap(&a.normal, &b.normal).max(gap(&a.tangent, &b.tangent));
    (each.clone().map(|(a, b)| gap(&a.position, &b.position)).fold(0.0, f32::max), each.map(turn).fold(0.0, f32::max))
}

fn drawn(stepper: &Stepper, mesh: &RenderMesh) -> Vec<RenderVertex> {
    let mut out = Vec::new();
    stepper.wrap(0, mesh, 1.0, &mut out).unwrap();
    out
}

#[test]
fn a_mesh_at_rest_is_where_the_source_has_it_on_every_level() {
    for (name, bundle, levels) in [("flag", flag(), 3), ("tube", tube(), 1)] {
        let mesh = RenderMesh::from_bundle(&bundle).unwrap().unwrap();
        let mut stepper = Stepper::on_cpu(scene(&bundle, 0.0), options()).unwrap();
        let source = drawn(&stepper, &mesh);
        for level in 1..=levels {
            stepper.set_level(0, level).unwrap();
            let reached = far(&drawn(&stepper, &mesh), &source);
            // Beyond the time in which a jump would be lost.
            assert!(reached.0 < 1e-6 && reached.1 < 2e-5, "{name}, level {level}: {reached:?}");
            // A tube of six sides is rounder or flatter than one of twelve, so that it moves.
            if name == "flag" {
                (0..20).for_each(|_| _ = stepper.advance(FRAME).unwrap());
                let (way, turn) = far(&drawn(&stepper, &mesh), &source);
                assert!(way < 1e-6 && turn < 2e-5, "{name}, level {level}: {way} m, {turn}");
            }
        }
    }
}

/// The fastest particle of a frame that moves nothing else \[m\].
fn fastest(stepper: &mut Stepper) -> f32 {
    let before = stepper.positions(0).unwrap().to_vec();
    stepper.advance(FRAME).unwrap();
    before.iter().zip(stepper.positions(0).unwrap()).map(|(a, b)| gap(a, b)).fold(0.0, f32::max)
}

#[test]
fn a_change_of_level_moves_no_vertex_and_none_jumps_after_it() {
    let bundle = flag();
    let mesh = RenderMesh::from_bundle(&bundle).unwrap().unwrap();
    let mut stepper = Stepper::on_cpu(scene(&bundle, 9.81), options()).unwrap();
    (0..30).for_each(|_| _ = stepper.advance(FRAME).unwrap());
    let mut before = drawn(&stepper, &mesh);
    let mut widest = 0.0f32;
    // Down, down by two, up again while the last jump still shows, and down to the finest.
    for (level, frames) in [(1, 30), (3, 4), (2, 3), (0, 30)] {
        stepper.set_level(0, level).unwrap();
        let now = drawn(&stepper, &mesh);
        let (way, turn) = far(&before, &now);
        assert!(way < 2e-6 && turn < 1e-4, "to level {level}: {way} m, {turn}");
        // The vertices that the new level alone would have: a stepper that came to it earlier, in the same state.
        let mut other = Stepper::on_cpu(scene(&bundle, 0.0), options()).unwrap();
        other.set_level(0, level).unwrap();
        (0..20).for_each(|_| _ = other.advance(FRAME).unwrap());
        other.set_state(0, &stepper.state(0).unwrap()).unwrap();
        let (jump, _) = far(&now, &drawn(&other, &mesh));
        widest = widest.max(jump);
        before = now;
        for frame in 0..frames {
            let fastest = fastest(&mut stepper);
            let now = drawn(&stepper, &mesh);
            let (way, turn) = far(&before, &now);
            // Offsets are up to 0.05 m long and turn with the cloth; a tenth of a jump is lost in a frame at most.
            let most = fastest + 0.06 * turn + 0.11 * jump + 1e-3;
            assert!(way < most, "level {level}, frame {frame}: {way} m; {fastest}, {turn}, {jump}");
            before = now;
        }
    }
    // Without that vertices would jump by this much.
    assert!(widest > 3e-3, "{widest}");
}

#[test]
fn another_mesh_and_another_cloth_are_told_apart_on_coarser_levels() {
    let (bundle, other) = (flag(), tube());
    let mesh = RenderMesh::from_bundle(&bundle).unwrap().unwrap();
    let wrong = RenderMesh::from_bundle(&other).unwrap().unwrap();
    let mut stepper = Stepper::on_cpu(scene(&bundle, 9.81), options()).unwrap();
    (0..10).for_each(|_| _ = stepper.advance(FRAME).unwrap());
    stepper.set_level(0, 1).unwrap();
    let error = stepper.wrap(0, &wrong, 1.0, &mut Vec::new()).unwrap_err().to_string();
    assert!(error.contains("825") && error.contains("117"), "{error}");
    // A second mesh of the same bundle has the same vertices, also while the jumps are those of the first.
    let second = RenderMesh::from_bundle(&bundle).unwrap().unwrap();
    assert_eq!(drawn(&stepper, &mesh), drawn(&stepper, &second));
}

#[cfg(feature = "gpu")]
mod on_the_gpu {
    use super::*;
    use crate::support::adapter;

    fn read(device: &wgpu::Device, queue: &wgpu::Queue, span: &Span) -> Vec<RenderVertex> {
        let list = read_back(device, queue, span).unwrap();
        let vertex = |v: &[[f32; 4]]| RenderVertex { position: v[0], normal: v[1], tangent: v[2] };
        list.chunks_exact(3).map(vertex).collect()
    }

    #[test]
    fn a_device_changes_levels_without_a_jump_too() {
        let Some((device, queue)) = adapter::device() else { return };
        for (name, bundle, levels) in [("flag", flag(), [1, 3, 0]), ("tube", tube(), [1, 0, 1])] {
            let mesh = RenderMesh::from_bundle(&bundle).unwrap().unwrap();
            for backend in [Backend::Gpu, Backend::Cpu] {
                let options = Options { backend, ..options() };
                let mut scene = scene(&bundle, 9.81);
                // Cloths that share dispatches.
                scene.cloths.push(scene.cloths[0].clone());
                let mut stepper = Stepper::new(scene, options, Some((&device, &queue))).unwrap();
                let frame = |stepper: &mut Stepper, dt: f64| {
                    let mut encoder = device.create_command_encoder(&Default::default());
                    stepper.record(&mut encoder, dt).unwrap();
                    let spans = [0, 1].map(|c| stepper.record_wrap(&mut encoder, c, &mesh, 1.0).unwrap());
                    queue.submit([encoder.finish()]);
                    spans.map(|span| read(&device, &queue, &span))
                };
                (0..20).for_each(|_| _ = frame(&mut stepper, FRAME));
                let mut before = frame(&mut stepper, FRAME);
                for level in levels {
                    stepper.set_levels(&[(0.into(), level), (1.into(), level)]).unwrap();
                    let now = frame(&mut stepper, 0.0);
                    for (before, now) in before.iter().zip(&now) {
                        let (way, turn) = far(before, now);
                        assert!(way < 2e-6 && turn < 1e-4, "{name}, {backend:?}, level {level}: {way} m, {turn}");
                    }
                    before = now;
                    (0..20).for_each(|_| before = frame(&mut stepper, FRAME));
                }
            }
        }
    }

    #[test]
    fn the_pass_of_a_jump_is_as_its_twin() {
        let Some((device, queue)) = adapter::device() else { return };
        let bundle = flag();
        let mesh = RenderMesh::from_bundle(&bundle).unwrap().unwrap();
        let on = |backend| Options { backend, ..options() };
        let mut gpu = Stepper::new(scene(&bundle, 9.81), on(Backend::Gpu), Some((&device, &queue))).unwrap();
        let mut cpu = Stepper::on_cpu(scene(&bundle, 9.81), on(Backend::Cpu)).unwrap();
        let frame = |gpu: &mut Stepper, cpu: &mut Stepper| {
            // The two part in each frame by what a frame rounds.
            gpu.set_state(0, &cpu.state(0).unwrap()).unwrap();
            cpu.advance(FRAME).unwrap();
            let mut encoder = device.create_command_encoder(&Default::default());
            gpu.record(&mut encoder, FRAME).unwrap();
            let span = gpu.record_wrap(&mut encoder, 0, &mesh, 1.0).unwrap();
            queue.submit([encoder.finish()]);
            (read(&device, &queue, &span), drawn(cpu, &mesh))
        };
        gpu.set_level(0, 1).unwrap();
        cpu.set_level(0, 1).unwrap();
        (0..25).for_each(|_| _ = frame(&mut gpu, &mut cpu));
        let (got, want) = frame(&mut gpu, &mut cpu);
        let apart = far(&got, &want);
        // The finer surface lies on the coarser one, so that both begin alike there.
        gpu.set_level(0, 0).unwrap();
        cpu.set_level(0, 0).unwrap();
        for n in 0..17 {
            let (got, want) = frame(&mut gpu, &mut cpu);
            let (way, turn) = far(&got, &want);
            assert!(way < 3.0 * apart.0 + 1e-5 && turn < 3.0 * apart.1 + 1e-3, "frame {n}: {way} m, {turn}; {apart:?}");
        }
    }
}
