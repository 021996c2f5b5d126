//! The mesh of the source between the skin and the cloth, by the map `blend`.

use crate::support::source_mesh;
use gimage_bundle::manifest::{Joint, RenderEntry, Skeleton};
use gimage_bundle::{BLEND, Bundle, COORD, Image, JOINTS, MapKind, OFFSET, RENDER_FILE, WEIGHTS};
use gimage_runtime::*;

const STILL: [f32; 16] = [1.0, 0.0, 0.0, 0.0, 0.0, 1.0, 0.0, 0.0, 0.0, 0.0, 1.0, 0.0, 0.0, 0.0, 0.0, 1.0];
const COUNT: usize = 300;
const LINEAR: Skinning = Skinning::Linear;

fn share(k: usize, by: f32) -> f32 {
    (k as f32 * by).fract()
}

/// The u, v and the weight of the second joint of a vertex.
fn place(k: usize) -> [f32; 3] {
    let v = if k < 20 { 0.0 } else { share(k, 0.754_877_7) };
    [share(k, 0.618_034), v, share(k, 0.37)]
}

/// A flag of 9 x 7 texels in the x-y plane, pinned along its upper edge, on two joints. Its mesh is on the skin in the first two rows and
/// on the cloth from the fifth on. `sets` of four joints per vertex, none for a mesh without joints.
fn flag(sets: usize, blend: bool) -> Bundle {
    flag_with(sets, blend, None)
}

/// The same; all vertices have a share of the blend of their own, if there is one.
fn flag_with(sets: usize, blend: bool, own: Option<f32>) -> Bundle {
    let mut bundle = Bundle::new("test");
    let piece = bundle.add_piece("cloth", 9, 7).unwrap();
    let image = |channels: u32, f: &dyn Fn(u32, u32) -> Vec<f32>| {
        let data = (0..63).flat_map(|k| f(k % 9, k / 9)).collect();
        Image { width: 9, height: 7, channels, data }
    };
    let position = |i: u32, j: u32| vec![0.05 * i as f32, -0.05 * j as f32, 0.0, if j == 0 { -1.0 } else { 1.0 }];
    bundle.insert(piece, MapKind::Position, image(4, &position)).unwrap();
    bundle.insert(piece, MapKind::Joints(0), image(4, &|_, _| vec![0.0; 4])).unwrap();
    bundle.insert(piece, MapKind::Weights(0), image(4, &|_, _| vec![1.0, 0.0, 0.0, 0.0])).unwrap();
    if blend {
        let of_row = |_: u32, j: u32| vec![[0.0, 0.0, 0.3, 0.7, 1.0, 1.0, 1.0][j as usize]];
        bundle.insert(piece, MapKind::Blend, image(1, &of_row)).unwrap();
    }
    let joint = |name: &str| Joint { name: name.into(), parent: None, inverse_bind: STILL };
    bundle.manifest.skeleton = Some(Skeleton { joints: vec![joint("a"), joint("b")] });
    bundle.manifest.pieces[0].constants.rest = Some([0.0; 4]);
    bundle.count().unwrap();
    let column = |f: &dyn Fn(usize) -> Vec<f32>| (0..COUNT).flat_map(f).collect::<Vec<f32>>();
    let rest = |k: usize| {
        let [u, v, _] = place(k);
        // 2 cm behind the flag, whose normal is -z.
        vec![0.4 * u, -0.3 * v, -0.02]
    };
    let coord = |k: usize| vec![0.0, place(k)[0], place(k)[1]];
    let mut attributes = vec![
        ("POSITION", 3, column(&rest)),
        ("NORMAL", 3, column(&|_| vec![0.0, 0.0, -1.0])),
        ("TANGENT", 4, column(&|_| vec![1.0, 0.0, 0.0, -1.0])),
        (COORD, 3, column(&coord)),
        (OFFSET, 3, column(&|_| vec![0.0, 0.0, 0.02])),
    ];
    let names = [[JOINTS.to_owned(), WEIGHTS.to_owned()], [format!("{JOINTS}1"), format!("{WEIGHTS}1")]];
    for (n, [joints, weights_of]) in names.iter().enumerate().take(sets) {
        // The second joint is in the last set.
        let weights = |k: usize| {
            let w = place(k)[2];
            match (sets, n) {
                (1, _) => vec![1.0 - w, w, 0.0, 0.0],
                (_, 0) => vec![1.0 - w, 0.0, 0.0, 0.0],
                _ => vec![0.0, w, 0.0, 0.0],
            }
        };
        attributes.push((joints, 4, column(&|_| vec![0.0, 1.0, 0.0, 0.0])));
        attributes.push((weights_of, 4, column(&weights)));
    }
    if let Some(own) = own {
        attributes.push((BLEND, 1, column(&|_| vec![own])));
    }
    bundle.render = Some(source_mesh::file(&attributes));
    bundle.manifest.render = Some(RenderEntry {
        file: RENDER_FILE.into(),
        vertices: COUNT as u64,
        bound: COUNT as u64,
        largest_offset: 0.02,
        transform: STILL.map(f64::from),
    });
    assert_eq!(gimage_bundle::validate(&bundle), []);
    bundle
}

fn scene(bundle: &Bundle, follows: bool) -> Scene {
    scene_by(bundle, follows, LINEAR)
}

fn scene_by(bundle: &Bundle, follows: bool, skinning: Skinning) -> Scene {
    let mut scene = Scene::new("blend");
    let mut cloth = Cloth::from_bundle("cloth", bundle).unwrap();
    cloth.skinning = skinning;
    if follows {
        cloth.follow_joints(&[STILL; 2]).unwrap();
    }
    scene.cloths.push(cloth);
    scene
}

fn options() -> Options {
    Options { substeps: Some(4), threads: 1, ..Options::default() }
}

/// Where both joints are: the first one forward, the second one turned about x as well.
fn matrices(frame: usize) -> [[f32; 16]; 2] {
    let (along, angle) = (0.01 * frame as f32, 0.05 * frame as f32);
    let (sin, cos) = angle.sin_cos();
    let mut first = STILL;
    first[14] = along;
    let second = [1.0, 0.0, 0.0, 0.0, 0.0, cos, sin, 0.0, 0.0, -sin, cos, 0.0, 0.0, 0.0, along, 1.0];
    [first, second]
}

fn gap<const N: usize>(a: &[f32], b: [f32; N]) -> f32 {
    a.iter().zip(b).map(|(a, b)| (a - b).abs()).fold(0.0, f32::max)
}

/// Where the skin of a vertex is.
fn skin(k: usize, [a, b]: [[f32; 16]; 2]) -> [f32; 3] {
    let [u, v, w] = place(k);
    let p = [0.4 * u, -0.3 * v, -0.02, 1.0];
    let at = |m: [f32; 16], r: usize| (0..4).map(|c| m[4 * c + r] * p[c]).sum::<f32>();
    std::array::from_fn(|r| (1.0 - w) * at(a, r) + w * at(b, r))
}

#[test]
fn vertices_have_shares_of_their_own() {
    for (map, own) in [(false, 0.0), (false, 0.25), (true, 0.5)] {
        let bundle = flag_with(1, map, Some(own));
        let mesh = RenderMesh::from_bundle(&bundle).unwrap().unwrap();
        assert_eq!(mesh.blended(), COUNT);
        let mut stepper = Stepper::on_cpu(scene(&bundle, true), options()).unwrap();
        stepper.set_joints(0, &matrices(5)).unwrap();
        stepper.advance(1.0 / 60.0).unwrap();
        let (mut out, mut cloth) = (Vec::new(), Vec::new());
        stepper.wrap(0, &mesh, 1.0, &mut out).unwrap();
        mesh.deform(stepper.positions(0).unwrap(), stepper.normals(0).unwrap(), &mut cloth).unwrap();
        let mut seen = 0;
        for (k, (vertex, cloth)) in out.iter().zip(&cloth).enumerate() {
            // The map is 1 from the fifth row on.
            if map && 6.0 * place(k)[1] < 4.01 {
                continue;
            }
            let at = skin(k, matrices(5));
            let mixed: [f32; 3] = std::array::from_fn(|c| at[c] + own * (cloth.position[c] - at[c]));
            assert!(gap(&vertex.position, mixed) < 1e-6, "{k}: {vertex:?}, not {mixed:?}");
            seen += usize::from(gap(&cloth.position, at) > 1e-4);
        }
        assert!(seen > 50, "{seen}");
    }
}

#[test]
fn the_border_is_on_the_skin_and_the_rest_on_the_cloth() {
    for sets in [1, 2] {
        let bundle = flag(sets, true);
        let mesh = RenderMesh::from_bundle(&bundle).unwrap().unwrap();
        let mut stepper = Stepper::on_cpu(scene(&bundle, true), options()).unwrap();
        for frame in 1..=20 {
            stepper.set_joints(0, &matrices(frame)).unwrap();
            stepper.advance(1.0 / 60.0).unwrap();
        }
        let (mut out, mut cloth) = (Vec::new(), Vec::new());
        stepper.wrap(0, &mesh, 1.0, &mut out).unwrap();
        mesh.deform(stepper.positions(0).unwrap(), stepper.normals(0).unwrap(), &mut cloth).unwrap();
        let (mut on_skin, mut on_cloth, mut between) = (0, 0, 0);
        for (k, (vertex, cloth)) in out.iter().zip(&cloth).enumerate() {
            let at = skin(k, matrices(20));
            match 6.0 * place(k)[1] {
                row if row < 0.99 => {
                    assert!(gap(&vertex.position, at) < 1e-6, "{k}: {vertex:?}, not {at:?}");
                    on_skin += 1;
                }
                row if row > 4.01 => {
                    assert_eq!(vertex, cloth);
                    on_cloth += 1;
                }
                row if (row - 2.0).abs() < 1e-3 => between += 1,
                row if (1.01..1.99).contains(&row) => {
                    let s = 0.3 * (row - 1.0);
                    let want: [f32; 3] = std::array::from_fn(|c| at[c] + s * (cloth.position[c] - at[c]));
                    assert!(gap(&vertex.position, want) < 1e-5, "{k}: {vertex:?}, not {want:?}");
                    let length = vertex.normal.iter().map(|x| x * x).sum::<f32>();
                    assert!((length - 1.0).abs() < 1e-5);
                    between += 1;
                }
                _ => {}
            }
        }
        assert!(on_skin > 40 && on_cloth > 60 && between > 30, "{on_skin} {on_cloth} {between}");
        assert_eq!(mesh.blended() + on_cloth, COUNT);
        // In two calls it is the same.
        stepper.blend(0, &mesh, 1.0, &mut cloth).unwrap();
        assert_eq!(cloth, out);
        mesh.deform(stepper.positions(0).unwrap(), stepper.normals(0).unwrap(), &mut cloth).unwrap();
        mesh.blend(&matrices(20), LINEAR, &mut cloth).unwrap();
        assert_eq!(cloth, out);
    }
}

#[test]
fn the_skin_lies_between_two_steps_as_pins_do() {
    let bundle = flag(1, true);
    let mesh = RenderMesh::from_bundle(&bundle).unwrap().unwrap();
    let mut stepper = Stepper::on_cpu(scene(&bundle, true), options()).unwrap();
    for frame in 1..=3 {
        stepper.set_joints(0, &matrices(frame)).unwrap();
        stepper.advance(1.0 / 60.0).unwrap();
    }
    let mut out = Vec::new();
    for fraction in [0.0, 0.5, 1.0] {
        stepper.wrap(0, &mesh, fraction, &mut out).unwrap();
        for (k, vertex) in out.iter().enumerate().take(20) {
            let [from, to] = [2, 3].map(|frame| skin(k, matrices(frame)));
            let share = 1.0 - (1.0 - fraction) / 4.0;
            let want: [f32; 3] = std::array::from_fn(|c| from[c] + share * (to[c] - from[c]));
            assert!(gap(&vertex.position, want) < 1e-6, "{fraction} {k}: {vertex:?}, not {want:?}");
        }
    }
    // Joints that rest in a frame rest between its steps.
    stepper.advance(1.0 / 60.0).unwrap();
    stepper.wrap(0, &mesh, 0.0, &mut out).unwrap();
    assert!(gap(&out[3].position, skin(3, matrices(3))) < 1e-6);
}

#[test]
fn without_joints_the_border_is_where_the_source_has_it() {
    for (bundle, follows) in [(flag(0, true), true), (flag(1, true), false)] {
        let mesh = RenderMesh::from_bundle(&bundle).unwrap().unwrap();
        let mut stepper = Stepper::on_cpu(scene(&bundle, follows), options()).unwrap();
        (0..10).for_each(|_| _ = stepper.advance(1.0 / 60.0).unwrap());
        let mut out = Vec::new();
        stepper.wrap(0, &mesh, 1.0, &mut out).unwrap();
        assert!((0..20).all(|k| gap(&out[k].position, skin(k, [STILL; 2])) < 1e-6));
    }
}

#[test]
fn a_mesh_without_the_map_has_no_rows_and_bad_calls_are_refused() {
    let bundle = flag(1, false);
    let plain = RenderMesh::from_bundle(&bundle).unwrap().unwrap();
    assert_eq!(plain.blended(), 0);
    plain.blend(&[], LINEAR, &mut []).unwrap();
    let bundle = flag(1, true);
    let mesh = RenderMesh::from_bundle(&bundle).unwrap().unwrap();
    let mut vertices = vec![RenderVertex::default(); COUNT];
    let error = |result: Result<()>| result.unwrap_err().to_string();
    assert!(error(mesh.blend(&[STILL], LINEAR, &mut vertices)).contains("1 joint matrices for 2"));
    assert!(error(mesh.blend(&[STILL, [f32::NAN; 16]], LINEAR, &mut vertices)).contains("not finite"));
    assert!(
        error(mesh.blend(&[STILL; 2], LINEAR, &mut vertices[1..])).contains("299 vertices for a render mesh of 300")
    );
    // A share above 1.
    let mut wrong = bundle.clone();
    wrong.images.get_mut(&(0, MapKind::Blend)).unwrap().data[40] = 1.5;
    let faults = gimage_bundle::validate(&wrong);
    assert!(faults.len() == 1 && faults[0].kind == gimage_bundle::FaultKind::Blend, "{faults:?}");
    // A file whose vertices follow a joint that does not exist.
    let mut broken = bundle.clone();
    broken.manifest.skeleton.as_mut().unwrap().joints.pop();
    assert!(error(RenderMesh::from_bundle(&broken).map(drop)).contains("joint"));
    assert!(gimage_bundle::validate(&broken).iter().any(|fault| fault.message.contains(JOINTS)));
}

#[cfg(feature = "gpu")]
mod on_the_gpu {
    use super::*;
    use crate::support::adapter;

    #[test]
    fn the_device_makes_what_the_twin_makes() {
        let Some((device, queue)) = adapter::device() else { return };
        const DUAL: Skinning = Skinning::DualQuaternion;
        let cases = [(1, true), (2, true), (0, true), (1, false)];
        let cases = cases.into_iter().flat_map(|(sets, follows)| [(sets, follows, LINEAR), (sets, follows, DUAL)]);
        for (sets, follows, skinning) in cases {
            let bundle = flag(sets, true);
            let mesh = RenderMesh::from_bundle(&bundle).unwrap().unwrap();
            for backend in [Backend::Gpu, Backend::Cpu] {
                let options = Options { backend, ..options() };
                let scene = scene_by(&bundle, follows, skinning);
                let mut stepper = Stepper::new(scene.clone(), options.clone(), Some((&device, &queue))).unwrap();
                let twin = Options { backend: Backend::Cpu, ..options };
                let mut twin = Stepper::on_cpu(scene, twin).unwrap();
                for (frame, fraction) in [1.0, 0.25, 1.0, 0.0].into_iter().enumerate() {
                    let mut encoder = device.create_command_encoder(&Default::default());
                    for stepper in [&mut stepper, &mut twin].into_iter().filter(|_| follows) {
                        stepper.set_joints(0, &matrices(frame + 1)).unwrap();
                    }
                    stepper.record(&mut encoder, 1.0 / 60.0).unwrap();
                    let span = stepper.record_wrap(&mut encoder, 0, &mesh, fraction).unwrap();
                    queue.submit([encoder.finish()]);
                    twin.advance(1.0 / 60.0).unwrap();
                    let mut want = Vec::new();
                    twin.wrap(0, &mesh, fraction, &mut want).unwrap();
                    let got = read_back(&device, &queue, &span).unwrap();
                    for (k, (got, want)) in got.chunks_exact(3).zip(&want).enumerate() {
                        let off = gap(&got[0], want.position).max(0.1 * gap(&got[1], want.normal));
                        let off = off.max(0.1 * gap(&got[2], want.tangent));
                        assert!(off < 2e-5, "{sets} sets, {backend:?}, frame {frame}, vertex {k}: {got:?} {want:?}");
                    }
                }
            }
        }
    }
}
