//! A bundle to disk and back, its surface to a mesh file and back, and texture coordinates all the way.

use gimage::closest::Closest;
use gimage::import::{ImportOptions, import};
use gimage::mesh::Semantic;
use gimage::reconstruct::Reconstruction;
use gimage::{Mesh, export};
use gimage_bundle::dir::{read_dir, validate_dir, write_dir};
use gimage_tests::{asset, build, point, surface, texels, texels_of, uv_of};

/// The corner positions of every triangle, as bits, so that numbering does not count.
fn corners(triangles: &[[u32; 3]], position: impl Fn(u32) -> [f32; 3]) -> Vec<[[u32; 3]; 3]> {
    triangles.iter().map(|t| t.map(|v| position(v).map(f32::to_bits))).collect()
}

fn read_back(surface: &Reconstruction, name: &str, bytes: &[u8]) -> Mesh {
    let folder = tempfile::tempdir().unwrap();
    let path = folder.path().join(name);
    std::fs::write(&path, bytes).unwrap();
    let mesh = import(&path, &ImportOptions::default()).unwrap().mesh;
    assert_eq!(mesh.triangles.len(), surface.triangles.len(), "{name}");
    let own = corners(&surface.triangles, |v| surface.positions[v as usize]);
    let back = corners(&mesh.triangles, |v| mesh.positions[v as usize].map(|x| x as f32));
    assert_eq!(own, back, "{name}");
    mesh
}

#[test]
fn bundles_and_meshes_come_back_as_they_were() {
    let folder = tempfile::tempdir().unwrap();
    for (name, options) in [("tshirt.glb", texels(2000)), ("dress.glb", texels(1500)), ("trousers.glb", point(2000))] {
        let built = build(&asset(name), &options).unwrap();
        let path = folder.path().join(name).with_extension("gim");
        write_dir(&built.bundle, &path, false).unwrap();
        assert!(write_dir(&built.bundle, &path, false).is_err(), "an existing bundle is not replaced unasked");
        write_dir(&built.bundle, &path, true).unwrap();
        let (_, faults) = validate_dir(&path).unwrap();
        assert!(faults.is_empty(), "{name}: {faults:?}");
        let bundle = read_dir(&path).unwrap();
        assert_eq!(bundle.images, built.bundle.images, "{name}");
        assert_eq!(bundle.encode().unwrap(), built.bundle.encode().unwrap(), "{name}");
        let welded = surface(&bundle);
        assert_eq!(welded, surface(&built.bundle), "{name}");
        let from_obj = read_back(&welded, "back.obj", export::obj(&welded).as_bytes());
        let from_glb = read_back(&welded, "back.glb", &export::glb(&welded).unwrap());
        for (mesh, within) in [(&from_obj, 1e-6), (&from_glb, 0.0)] {
            let uv = mesh.channel(&Semantic::TexCoord(0)).unwrap();
            let own = welded.pieces[0].uv.as_ref().unwrap();
            for (t, corners) in own.iter().enumerate() {
                for (c, want) in corners.iter().enumerate() {
                    let got = uv.at(t, c).unwrap();
                    // OBJ turns v upside down, which rounds.
                    let off = (got[0] - want[0]).abs().max((got[1] - want[1]).abs());
                    assert!(off <= within, "{name}: triangle {t}: {got:?} instead of {want:?}");
                }
            }
        }
    }
}

#[test]
fn building_the_result_again_keeps_its_topology() {
    let folder = tempfile::tempdir().unwrap();
    let first = build(&asset("trousers.glb"), &texels(2000)).unwrap();
    let path = folder.path().join("again.glb");
    std::fs::write(&path, export::glb(&surface(&first.bundle)).unwrap()).unwrap();
    let second = build(&path, &texels(2000)).unwrap();
    gimage_tests::check("again", &second);
    let own = |b: &gimage::pipeline::Built| {
        let s = b.bundle.manifest.pieces[0].surface.clone().unwrap();
        (s.euler, s.loops)
    };
    assert_eq!(own(&first), own(&second));
    assert_eq!(second.bundle.manifest.pieces.len(), 1);
}

/// Every texel lies on the source, and has the texture coordinates of the source there: of one of its sides on a seam.
#[test]
fn texels_have_the_texture_coordinates_of_their_place() {
    for name in ["tshirt.glb", "dress.glb", "cape.glb"] {
        let built = build(&asset(name), &point(4096)).unwrap();
        let mesh = import(&asset(name), &ImportOptions::default()).unwrap().mesh;
        let channel = mesh.channel(&Semantic::TexCoord(0)).unwrap();
        let (mut lo, mut hi) = ([f32::MAX; 2], [f32::MIN; 2]);
        for v in channel.values.chunks_exact(2) {
            (0..2).for_each(|c| (lo[c], hi[c]) = (lo[c].min(v[c]), hi[c].max(v[c])));
        }
        let closest = Closest::new(&mesh.positions, &mesh.triangles);
        let all = uv_of(&built.bundle, 0).unwrap();
        let mut worst = 0.0f64;
        for (k, (p, uv)) in texels_of(&built.bundle, 0).iter().zip(&all).enumerate() {
            let at = [p[0], p[1], p[2]].map(f64::from);
            let near = closest.project(at).unwrap();
            assert!(near.distance < 1e-6, "{name}, texel {k}: {} m off the surface", near.distance);
            assert!((0..2).all(|c| lo[c] - 1e-4 <= uv[c] && uv[c] <= hi[c] + 1e-4), "{name}, texel {k}: {uv:?}");
            // On an edge or a vertex any triangle there may be the one that was read.
            let off = mesh
                .triangles
                .iter()
                .enumerate()
                .filter(|(t, _)| near_triangle(&mesh, *t, at))
                .filter_map(|(t, _)| {
                    let b = barycentric(mesh.corners(t), at);
                    let value =
                        |c: usize| (0..3).map(|k| Some(b[k] * f64::from(channel.at(t, k)?[c]))).sum::<Option<f64>>();
                    Some((value(0)? - f64::from(uv[0])).abs().max((value(1)? - f64::from(uv[1])).abs()))
                })
                .fold(f64::INFINITY, f64::min);
            worst = worst.max(off);
            assert!(off < 1e-4, "{name}, texel {k} at {at:?}: {uv:?} is {off} away");
        }
        assert!(worst.is_finite(), "{name}");
    }
}

fn minus(a: [f64; 3], b: [f64; 3]) -> [f64; 3] {
    std::array::from_fn(|k| a[k] - b[k])
}

fn dot(a: [f64; 3], b: [f64; 3]) -> f64 {
    (0..3).map(|k| a[k] * b[k]).sum()
}

/// Weights of the foot of a point on the plane of a triangle.
fn barycentric([a, b, c]: [[f64; 3]; 3], p: [f64; 3]) -> [f64; 3] {
    let (u, v, w) = (minus(b, a), minus(c, a), minus(p, a));
    let (uu, uv, vv, wu, wv) = (dot(u, u), dot(u, v), dot(v, v), dot(w, u), dot(w, v));
    let d = uu * vv - uv * uv;
    let (s, t) = ((wu * vv - wv * uv) / d, (wv * uu - wu * uv) / d);
    [1.0 - s - t, s, t]
}

/// Whether a point lies on a triangle, to the rounding of f32.
fn near_triangle(mesh: &Mesh, t: usize, p: [f64; 3]) -> bool {
    let corners = mesh.corners(t);
    let inside = (0..3).all(|c| {
        let (lo, hi) = corners.iter().fold((f64::MAX, f64::MIN), |(lo, hi), q| (lo.min(q[c]), hi.max(q[c])));
        lo - 1e-6 <= p[c] && p[c] <= hi + 1e-6
    });
    if !inside {
        return false;
    }
    let b = barycentric(corners, p);
    let foot: [f64; 3] = std::array::from_fn(|k| (0..3).map(|c| b[c] * corners[c][k]).sum());
    let off = minus(foot, p);
    b.iter().all(|b| *b > -1e-4) && dot(off, off).sqrt() < 1e-6
}
