//! Meshes that are bound to a cloth: in its frame at rest, bent and turned, and on the GPU as on the CPU.

use crate::support::bound_mesh::{bundle, flag_texel, share, spread, tube_texel};
use gimage_bundle::{Bundle, MapKind};
use gimage_runtime::*;

/// A flag in the x-y plane, pinned along its upper edge.
fn flag(count: usize) -> Bundle {
    bundle((9, 7), flag_texel, &spread(count))
}

/// A tube around y with a seam.
fn tube(count: usize) -> Bundle {
    bundle((13, 8), tube_texel, &spread(count))
}

fn scene(bundle: &Bundle) -> Scene {
    let mut scene = Scene::new("wrap");
    let mut cloth = Cloth::from_bundle("cloth", bundle).unwrap();
    cloth.damping = 0.5;
    scene.cloths.push(cloth);
    scene.gravity = [2.0, -9.0, 4.0];
    scene
}

fn options() -> Options {
    Options { substeps: Some(4), threads: 1, ..Options::default() }
}

fn gap(a: &[f32; 4], b: &[f32; 4]) -> f32 {
    a.iter().zip(b).map(|(a, b)| (a - b).abs()).fold(0.0, f32::max)
}

#[test]
fn vertices_are_where_their_offsets_put_them() {
    let bundle = flag(60);
    let mesh = RenderMesh::from_bundle(&bundle).unwrap().unwrap();
    let stepper = Stepper::on_cpu(scene(&bundle), options()).unwrap();
    let mut out = Vec::new();
    stepper.wrap(0, &mesh, 1.0, &mut out).unwrap();
    assert_eq!((out.len(), mesh.parts.len(), mesh.uv.len()), (60, 1, 60));
    for (k, vertex) in out.iter().enumerate() {
        let want = if k % 7 == 6 {
            [0.1, 0.2, k as f32 * 1e-3, 1.0]
        } else {
            let [u, v] =
                if k < 4 { [(k % 2) as f32, (k / 2) as f32] } else { [share(k, 0.618_034), share(k, 0.754_877_7)] };
            // Texels run to the right and down, as seen from behind: the normal of the flag is -z, its bitangent -y... times -z is y.
            let [x, y, z] = [0.01 * share(k, 0.3), -0.01 * share(k, 0.7), 0.05 * share(k, 0.1)];
            [0.4 * u + x, -0.3 * v - y, -z, 1.0]
        };
        assert!(gap(&vertex.position, &want) < 1e-6, "vertex {k}: {vertex:?}, not {want:?}");
        // Rest: normals and tangents are those of the file.
        let angle = 6.0 * share(k, 0.37);
        assert!(gap(&vertex.normal, &[0.0, angle.cos(), angle.sin(), 0.0]) < 1e-6, "vertex {k}: {vertex:?}");
        assert!(gap(&vertex.tangent, &[1.0, 0.0, 0.0, if k % 2 == 0 { 1.0 } else { -1.0 }]) < 1e-6);
    }
}

#[test]
fn offsets_of_a_bent_sheet_stay_within_one_percent() {
    // 0.4 m of cloth bent by 30 degrees around an axis along y; a vertex 2 cm above is 2 cm above the arc.
    let bundle = flag(400);
    let mesh = RenderMesh::from_bundle(&bundle).unwrap().unwrap();
    let radius = 0.4 / 30f64.to_radians();
    let bend = |x: f64, y: f64, height: f64| {
        let angle = x / radius;
        [(radius + height) * angle.sin(), y, (radius + height) * angle.cos() - radius]
    };
    let texel = |k: usize| [0.05 * (k % 9) as f64, -0.05 * (k / 9) as f64];
    let positions: Vec<[f32; 4]> = (0..63)
        .map(|k| {
            let [x, y, z] = bend(texel(k)[0], texel(k)[1], 0.0).map(|x| x as f32);
            [x, y, z, 1.0]
        })
        .collect();
    // The normals of the pass, of which the ends have only triangles on one side.
    let mut bent = scene(&bundle);
    let at: Vec<(u32, [f32; 3])> =
        positions.iter().enumerate().map(|(k, [x, y, z, _])| (k as u32, [*x, *y, *z])).collect();
    bent.cloths[0] = Cloth::from_bundle("cloth", &moved(&bundle, &at)).unwrap();
    let stepper = Stepper::on_cpu(bent, options()).unwrap();
    let mut out = Vec::new();
    mesh.deform(&positions, stepper.normals(0).unwrap(), &mut out).unwrap();
    let share = |k: usize, by: f32| f64::from(share(k, by));
    let mut worst = 0.0f64;
    for (k, vertex) in out.iter().enumerate().skip(4).filter(|(k, _)| k % 7 != 6) {
        let (u, v) = (share(k, 0.618_034), share(k, 0.754_877_7));
        let [x, y, z] = [0.01 * share(k, 0.3), -0.01 * share(k, 0.7), 0.05 * share(k, 0.1)];
        let size = (x * x + y * y + z * z).sqrt();
        // The foot on the grid is within the chord of the arc: the offset alone is judged.
        let (i, f) = ((8.0 * u).floor().min(7.0), 8.0 * u - (8.0 * u).floor().min(7.0));
        let [a, b] = [0.05 * i, 0.05 * (i + 1.0)].map(|x| bend(x, 0.0, 0.0));
        let foot: [f64; 3] = std::array::from_fn(|c| a[c] + f * (b[c] - a[c]));
        let angle = 0.4 * u / radius;
        let want =
            [foot[0] + x * angle.cos() - z * angle.sin(), -0.3 * v - y, foot[2] - x * angle.sin() - z * angle.cos()];
        let off = (0..3).map(|c| (f64::from(vertex.position[c]) - want[c]).powi(2)).sum::<f64>().sqrt();
        // Normals at the border of the sheet are those of the triangles on one side, up to half a texel of turn off.
        if (0.13..0.87).contains(&u) && (0.17..0.83).contains(&v) && size > 0.01 {
            worst = worst.max(off / size);
        }
    }
    assert!(worst > 0.0 && worst < 0.01, "{worst}");
}

/// The bundle with texels elsewhere.
fn moved(bundle: &Bundle, at: &[(u32, [f32; 3])]) -> Bundle {
    let mut bundle = bundle.clone();
    let image = bundle.images.get_mut(&(0, MapKind::Position)).unwrap();
    for (k, p) in at {
        image.data[4 * *k as usize..4 * *k as usize + 3].copy_from_slice(p);
    }
    bundle
}

#[test]
fn a_mesh_of_another_bundle_is_refused() {
    let mesh = RenderMesh::from_bundle(&tube(9)).unwrap().unwrap();
    let stepper = Stepper::on_cpu(scene(&flag(9)), options()).unwrap();
    let error = stepper.wrap(0, &mesh, 1.0, &mut Vec::new()).unwrap_err().to_string();
    assert!(error.contains("104") && error.contains("63"), "{error}");
    assert!(mesh.deform(&[], &[], &mut Vec::new()).is_err());
    assert!(stepper.wrap(1, &mesh, 1.0, &mut Vec::new()).is_err());
}

#[test]
fn a_vertex_lies_between_two_steps_as_the_grid_does() {
    let bundle = flag(40);
    let mesh = RenderMesh::from_bundle(&bundle).unwrap().unwrap();
    let mut stepper = Stepper::on_cpu(scene(&bundle), options()).unwrap();
    (0..20).for_each(|_| _ = stepper.advance(1.0 / 60.0).unwrap());
    let [mut first, mut half, mut last] = [const { Vec::new() }; 3];
    stepper.wrap(0, &mesh, 0.0, &mut first).unwrap();
    stepper.wrap(0, &mesh, 0.5, &mut half).unwrap();
    stepper.wrap(0, &mesh, 1.0, &mut last).unwrap();
    for fraction in [f32::NAN, f32::INFINITY] {
        let error = stepper.wrap(0, &mesh, fraction, &mut Vec::new()).unwrap_err().to_string();
        assert!(error.contains("fraction"), "{error}");
    }
    let mut most = 0.0f32;
    for ((a, h), b) in first.iter().zip(&half).zip(&last) {
        let middle = [0, 1, 2, 3].map(|c| 0.5 * (a.position[c] + b.position[c]));
        assert!(gap(&middle, &h.position) < 1e-4, "{a:?} {h:?} {b:?}");
        most = most.max(gap(&a.position, &b.position));
    }
    assert!(most > 1e-4, "nothing moved");
}

#[cfg(feature = "gpu")]
mod on_the_gpu {
    use super::*;
    use crate::support::adapter;

    #[test]
    fn the_device_makes_what_the_twin_makes() {
        let Some((device, queue)) = adapter::device() else { return };
        for (name, bundle) in [("flag", flag(3000)), ("tube", tube(3000))] {
            let mesh = RenderMesh::from_bundle(&bundle).unwrap().unwrap();
            for backend in [Backend::Gpu, Backend::Cpu] {
                let options = Options { backend, ..options() };
                let mut stepper = Stepper::new(scene(&bundle), options.clone(), Some((&device, &queue))).unwrap();
                let mut twin = Stepper::on_cpu(scene(&bundle), Options { backend: Backend::Cpu, ..options }).unwrap();
                for (frame, fraction) in [1.0, 0.25, 1.0, 0.0].into_iter().enumerate() {
                    let mut encoder = device.create_command_encoder(&Default::default());
                    stepper.record(&mut encoder, 1.0 / 60.0).unwrap();
                    let span = stepper.record_wrap(&mut encoder, 0, &mesh, fraction).unwrap();
                    let again = stepper.record_wrap(&mut encoder, 0, &mesh, fraction).unwrap();
                    assert_eq!(span, again);
                    queue.submit([encoder.finish()]);
                    twin.advance(1.0 / 60.0).unwrap();
                    let mut want = Vec::new();
                    twin.wrap(0, &mesh, fraction, &mut want).unwrap();
                    let got = read_back(&device, &queue, &span).unwrap();
                    assert_eq!(got.len(), 3 * want.len());
                    for (k, (got, want)) in got.chunks_exact(3).zip(&want).enumerate() {
                        let off = gap(&got[0], &want.position).max(0.1 * gap(&got[1], &want.normal));
                        let off = off.max(0.1 * gap(&got[2], &want.tangent));
                        assert!(off < 2e-5, "{name}, {backend:?}, frame {frame}, vertex {k}: {got:?} {want:?}");
                    }
                }
            }
        }
    }

    #[test]
    fn a_mesh_that_nobody_asks_for_has_no_dispatch() {
        let Some((device, queue)) = adapter::device() else { return };
        let options = Options { backend: Backend::Gpu, ..options() };
        let stepper = Stepper::new(scene(&flag(9)), options, Some((&device, &queue))).unwrap();
        assert!(!stepper.plan().to_string().contains("wrap"));
    }
}
