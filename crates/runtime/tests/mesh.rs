//! Data that renderers of meshes need beside positions: indices, texture coordinates and tangents.

use crate::support::rig::{FRAME, Rig, largest};
use crate::support::{self, curtain, device_with, hung_tube, on_colliders, scene, two_charts};
use gimage_runtime::*;

type Device = (wgpu::Device, wgpu::Queue);

fn options() -> Options {
    Options { substeps: Some(2), threads: 1, ..Options::default() }
}

/// A square of 4 x 4 particles, without some of them.
fn gappy(missing: &[usize]) -> Cloth {
    let flat = Flat::square("gaps", 4).cloth().unwrap();
    let mut particles = flat.particles().to_vec();
    missing.iter().for_each(|k| particles[*k] = Particle::None);
    let (positions, grids) = (flat.positions().to_vec(), flat.grids().to_vec());
    let rest = flat.rest().clone();
    Cloth::new(Parts { name: "gaps".into(), grids, positions, particles, rest, mass: Mass::Constant(1e-3) }).unwrap()
}

fn cut(stepper: &mut Stepper) {
    stepper.cut([0.3, -0.45, 3.0], [-4.0, -0.45, -2.0], [0.6, -0.45, -2.0]).unwrap();
}

#[test]
fn triangles_are_those_of_the_quads_and_face_as_normals_do() {
    for cloth in [curtain(6), hung_tube(3), two_charts(5), gappy(&[5])] {
        let mut stepper = Stepper::on_cpu(scene(cloth.clone()), options()).unwrap();
        stepper.advance(FRAME).unwrap();
        let (now, indices) = (stepper.positions(0).unwrap(), cloth.indices());
        assert_eq!(stepper.indices(0).unwrap(), indices);
        let normals = stepper.normals(0).unwrap();
        for t in indices.chunks_exact(3) {
            let [a, b, c] = [0, 1, 2].map(|n| now[t[n] as usize].map(f64::from));
            let (e, f) = ([0, 1, 2].map(|n| b[n] - a[n]), [0, 1, 2].map(|n| c[n] - a[n]));
            let across = [e[1] * f[2] - e[2] * f[1], e[2] * f[0] - e[0] * f[2], e[0] * f[1] - e[1] * f[0]];
            let faces = |k: u32| (0..3).map(|n| across[n] * f64::from(normals[k as usize][n])).sum::<f64>();
            // The tip of the tube is one point, whose triangles have no area.
            let area = across.iter().map(|x| x * x).sum::<f64>().sqrt();
            assert!(area < 1e-6 || t.iter().all(|k| faces(*k) > 0.0), "{}: {t:?}", cloth.name());
        }
    }
    assert_eq!(curtain(6).indices()[..6], [0, 7, 6, 0, 1, 7]);
    assert_eq!(two_charts(5).indices().len(), 2 * 16 * 2 * 3);
    // Around a particle that is missing, each quad is one triangle; two missing neighbours leave none.
    assert_eq!((gappy(&[5]).indices().len(), gappy(&[0]).indices().len()), (3 * (5 * 2 + 4), 3 * (8 * 2 + 1)));
    assert_eq!(gappy(&[0]).indices()[..3], [4, 1, 5]);
    assert_eq!(gappy(&[0, 1]).indices()[..3], [5, 2, 6]);
    assert_eq!(Stepper::on_cpu(scene(curtain(3)), options()).unwrap().indices(1), None);
}

/// The triangles in the index buffer of a cloth that are not points.
fn buffered(rig: &mut Rig, (device, queue): &Device, cloth: usize) -> Vec<u32> {
    let span = rig.stepper.index_buffer(cloth).unwrap();
    assert_eq!(rig.stepper.buffers(cloth).unwrap().indices, Some(span.clone()));
    let all = read_back_u32(device, queue, &span).unwrap();
    assert_eq!(all.len(), 6 * rig.stepper.scene().cloths[cloth].len());
    let triangles = all.chunks_exact(3).filter(|t| t[0] != t[1] || t[0] != t[2]);
    triangles.flatten().copied().collect()
}

#[test]
fn index_buffers_follow_cuts_and_states() {
    let Some(device) = device_with(device_limits) else { return };
    let mut all = scene(curtain(12));
    all.cloths.push(two_charts(9));
    let mut twin = Rig::cpu(all.clone(), &options());
    let whole: Vec<_> = all.cloths.iter().map(Cloth::indices).collect();
    cut(&mut twin.stepper);
    twin.frame(FRAME);
    let left = [0, 1].map(|cloth| twin.stepper.indices(cloth).unwrap());
    assert!((0..2).all(|c| left[c].len() < whole[c].len() && left[c].len() > whole[c].len() / 2));
    for backend in [Backend::Gpu, Backend::Cpu] {
        let mut rig = Rig::on(backend, all.clone(), &options(), &device);
        assert!(rig.stepper.buffers(0).unwrap().indices.is_none());
        let start = rig.stepper.state(0).unwrap();
        assert_eq!(buffered(&mut rig, &device, 0), whole[0]);
        let compiled = rig.stepper.compiled().unwrap().pipelines;
        rig.frame(FRAME);
        assert_eq!(rig.stepper.compiled().unwrap().pipelines, compiled, "a frame without a cut has no pass more");
        rig.stepper.restore(&twin_start(&all)).unwrap();
        cut(&mut rig.stepper);
        rig.frame(FRAME);
        assert_eq!(buffered(&mut rig, &device, 0), left[0], "{backend:?}");
        assert_eq!(rig.stepper.indices(0).is_some(), backend == Backend::Cpu);
        // First asked for when it is cut already.
        buffered(&mut rig, &device, 1);
        rig.frame(0.0);
        assert_eq!(buffered(&mut rig, &device, 1), left[1], "{backend:?}");
        // Whole again, and cut again.
        let torn = rig.stepper.state(0).unwrap();
        for (state, expected) in [(&start, &whole[0]), (&torn, &left[0])] {
            rig.stepper.set_state(0, state).unwrap();
            rig.frame(FRAME);
            assert_eq!(buffered(&mut rig, &device, 0), *expected, "{backend:?}");
        }
        assert!(rig.stepper.index_buffer(2).is_err());
    }
    assert!(matches!(twin.stepper.index_buffer(0), Err(Error::NoGpu(_))));
}

#[test]
fn lists_follow_their_cloths_where_others_come_and_go() {
    let Some(device) = support::device() else { return };
    let options = Options { fused: false, ..options() };
    let mut all = scene(curtain(12));
    all.cloths.extend([two_charts(9), gappy(&[5]), curtain(9)]);
    let changes: [fn(&mut Stepper); 3] = [
        |_| (),
        |stepper| {
            stepper.remove_cloth(2).unwrap();
            stepper.add_cloth(gappy(&[0, 1])).unwrap();
        },
        |stepper| {
            cut(stepper);
            // One goes before the frame of the cut. A cut spares what comes after it.
            stepper.remove_cloth(0).unwrap();
            stepper.add_cloth(curtain(12)).unwrap();
        },
    ];
    for backend in [Backend::Gpu, Backend::Cpu] {
        let mut rig = Rig::on(backend, all.clone(), &options, &device);
        let mut twin = Rig::cpu(all.clone(), &options);
        for (n, change) in changes.iter().enumerate() {
            for rig in [&mut rig, &mut twin] {
                change(&mut rig.stepper);
                rig.frame(FRAME);
            }
            for cloth in 0..4 {
                let name = format!("{backend:?} {n} {cloth}");
                assert_eq!(buffered(&mut rig, &device, cloth), twin.stepper.indices(cloth).unwrap(), "{name}");
                let apart = largest(&recorded(&mut rig, &device, cloth), &twin.stepper.tangents(cloth).unwrap());
                assert!(apart < 1e-3, "{name}: {apart}");
            }
        }
        let [charts, curtain, _, late] = [0, 1, 2, 3].map(|c| twin.stepper.indices(c).unwrap().len());
        assert!(charts < two_charts(9).indices().len() && curtain < support::curtain(9).indices().len());
        assert_eq!(late, support::curtain(12).indices().len());
    }
}

/// The scene as it begins.
fn twin_start(all: &Scene) -> Snapshot {
    Stepper::on_cpu(all.clone(), options()).unwrap().snapshot().unwrap()
}

/// The tangents of a cloth after some frames, on either backend.
fn tangents(rig: &mut Rig, device: Option<&Device>) -> Vec<[f32; 4]> {
    let Some(device) = device else { return rig.stepper.tangents(0).unwrap() };
    assert_eq!(rig.stepper.tangents(0), None);
    recorded(rig, device, 0)
}

/// The tangents of a cloth in its buffer.
fn recorded(rig: &mut Rig, (device, queue): &Device, cloth: usize) -> Vec<[f32; 4]> {
    let mut encoder = device.create_command_encoder(&Default::default());
    let span = rig.stepper.record_tangents(&mut encoder, cloth).unwrap();
    queue.submit([encoder.finish()]);
    assert_eq!(rig.stepper.buffers(cloth).unwrap().tangents, Some(span.clone()));
    read_back(device, queue, &span).unwrap()
}

#[test]
fn tangents_lie_along_u_and_both_backends_agree() {
    // A turn, a mirror image and a coordinate that jumps.
    let charts: [fn(f32, f32) -> [f32; 2]; 4] = [
        |u, v| [u, v],
        |u, v| [0.8 * u - 0.6 * v, 0.6 * u + 0.8 * v],
        |u, v| [3.0 - 2.0 * u, v],
        |u, v| [if u < 0.5 { u } else { u + 7.0 }, v],
    ];
    let along = [[1.0, 0.0, 0.0], [0.8, 0.0, -0.6], [-1.0, 0.0, 0.0], [1.0, 0.0, 0.0]];
    for (chart, expected) in charts.into_iter().zip(along) {
        let mut flat = Flat::square("flat", 9).cloth().unwrap();
        let uv: Vec<_> = flat.uv().into_iter().map(|[u, v]| chart(u, v)).collect();
        flat.set_grain(Some(uv.clone())).unwrap();
        assert_eq!(flat.uv(), uv);
        let stepper = Stepper::on_cpu(scene(flat), options()).unwrap();
        let normals = stepper.normals(0).unwrap();
        for (t, n) in stepper.tangents(0).unwrap().into_iter().zip(normals) {
            assert!((0..3).all(|c| (t[c] - expected[c]).abs() < 1e-5), "{t:?} {expected:?}");
            // v grows along z, and across u.
            let [x, z] = [n[1] * t[2] - n[2] * t[1], n[0] * t[1] - n[1] * t[0]].map(|c| c * t[3]);
            assert!(z > 0.5 && (x * expected[0] + z * expected[2]).abs() < 1e-5, "{t:?} {n:?}");
        }
    }
    let roomy = device_with(device_limits);
    for (name, mut all) in [("flat", on_colliders(12)), ("seams", scene(hung_tube(1))), ("cut", scene(curtain(12)))] {
        all.wind = Some(support::wind(false));
        let mut rigs = vec![(Rig::cpu(all.clone(), &options()), None)];
        rigs.extend(roomy.iter().map(|device| (Rig::gpu(all.clone(), &options(), device), Some(device))));
        let found: Vec<_> = (rigs.iter_mut())
            .map(|(rig, device)| {
                if name == "cut" {
                    cut(&mut rig.stepper);
                }
                rig.frames(1);
                (tangents(rig, *device), rig.normals(0))
            })
            .collect();
        for (tangents, normals) in &found {
            for (t, n) in tangents.iter().zip(normals) {
                let dot = |a: &[f32; 4], b: &[f32; 4]| (0..3).map(|c| a[c] * b[c]).sum::<f32>();
                assert!(dot(t, n).abs() < 1e-5 && (dot(t, t) - 1.0).abs() < 1e-5, "{name}: {t:?} {n:?}");
            }
        }
        if let [(cpu, _), (gpu, _)] = &found[..] {
            let apart = largest(cpu, gpu);
            assert!(apart < 1e-3 && cpu.iter().zip(gpu).all(|(a, b)| a[3] == b[3]), "{name}: {apart}");
        }
    }
}

#[test]
fn tangents_do_not_reach_across_a_cut() {
    // A curtain whose u runs down is cut below its fourth row, and what hangs below is moved to the side.
    let mut cloth = curtain(8);
    let down: Vec<_> = cloth.uv().into_iter().map(|[u, v]| [v, u]).collect();
    cloth.set_grain(Some(down)).unwrap();
    let device = support::device();
    let mut rigs = vec![(Rig::cpu(scene(cloth.clone()), &options()), None)];
    rigs.extend(device.iter().map(|device| (Rig::gpu(scene(cloth.clone()), &options(), device), Some(device))));
    for (mut rig, device) in rigs {
        rig.stepper.cut([0.5, -0.5, 3.0], [-4.0, -0.5, -2.0], [5.0, -0.5, -2.0]).unwrap();
        let lower: Vec<usize> = (32..64).collect();
        let shift = [[1.0, 0.0, 0.0, 0.0], [0.0, 1.0, 0.0, 0.0], [0.0, 0.0, 1.0, 0.0], [5.0, 0.0, 0.0, 1.0]];
        rig.stepper.transform(0, &lower, shift).unwrap();
        rig.frame(0.0);
        for t in tangents(&mut rig, device) {
            assert!(t[0].abs() < 1e-5 && (t[1] + 1.0).abs() < 1e-5 && t[3] == -1.0, "{}: {t:?}", rig.name());
        }
    }
}

#[test]
fn tangents_do_not_reach_across_a_cut_at_a_ragged_border() {
    // Without particle 7 the quad of particles 2 and 3 has one triangle. It is cut away, and particle 3 is moved along it.
    let device = support::device();
    let mut rigs = vec![(Rig::cpu(scene(gappy(&[7])), &options()), None)];
    rigs.extend(device.iter().map(|device| (Rig::gpu(scene(gappy(&[7])), &options(), device), Some(device))));
    for (mut rig, device) in rigs {
        rig.stepper.cut([0.8, 3.0, 0.05], [0.8, -3.0, -0.5], [0.8, -3.0, 0.2]).unwrap();
        let shift = [[1.0, 0.0, 0.0, 0.0], [0.0, 1.0, 0.0, 0.0], [0.0, 0.0, 1.0, 0.0], [0.0, 0.0, 5.0, 1.0]];
        rig.stepper.transform(0, &[3], shift).unwrap();
        rig.frame(0.0);
        let holes = rig.holes(0).unwrap();
        assert!((0..16).all(|k| (holes[k] != 0) == (k == 2)), "{holes:?}");
        let t = tangents(&mut rig, device)[2];
        assert!((t[0] - 1.0).abs() < 1e-5 && t[2].abs() < 1e-5, "{}: {t:?}", rig.name());
    }
}
