//! Where a render mesh is, beside its source.

#![allow(clippy::print_stdout)]

use std::collections::HashMap;

use gimage_bundle::{Bundle, RenderFile, RenderPrimitive};
use gimage_runtime::{Cloth, Options, RenderMesh, RenderVertex, Scene, Stepper};

/// Where the source has each vertex \[m\], in the order of a [`RenderMesh`], and its unit normal.
pub fn source(bundle: &Bundle) -> Vec<([f64; 3], [f64; 3])> {
    let transform = bundle.manifest.render.as_ref().unwrap().transform;
    let file = RenderFile::parse(bundle.render.as_ref().unwrap()).unwrap();
    let apply = |m: &[f64; 16], p: [f64; 3], w: f64| -> [f64; 3] {
        std::array::from_fn(|k| m[k] * p[0] + m[4 + k] * p[1] + m[8 + k] * p[2] + w * m[12 + k])
    };
    let of = |p: &RenderPrimitive| -> Vec<_> {
        let place = |v: usize| {
            let at = apply(&transform, apply(&p.world, p.positions[v].map(f64::from), 1.0), 1.0);
            // Transforms of the assets keep angles.
            let n =
                p.normals.get(v).map_or([0.0; 3], |n| apply(&transform, apply(&p.world, n.map(f64::from), 0.0), 0.0));
            let length = n.iter().map(|x| x * x).sum::<f64>().sqrt().max(1e-30);
            (at, n.map(|x| x / length))
        };
        (0..p.positions.len()).map(place).collect()
    };
    file.primitives().unwrap().iter().flat_map(of).collect()
}

pub fn distance(a: [f64; 3], b: &[f32]) -> f64 {
    (0..3).map(|k| (a[k] - f64::from(b[k])).powi(2)).sum::<f64>().sqrt()
}

pub fn diagonal(points: impl Iterator<Item = [f64; 3]>) -> f64 {
    let (mut lo, mut hi) = ([f64::INFINITY; 3], [f64::NEG_INFINITY; 3]);
    points.for_each(|p| (0..3).for_each(|k| (lo[k], hi[k]) = (lo[k].min(p[k]), hi[k].max(p[k]))));
    (0..3).map(|k| (hi[k] - lo[k]).powi(2)).sum::<f64>().sqrt()
}

/// A stepper of the bundle alone, on one thread.
pub fn stepper(bundle: &Bundle) -> Stepper {
    let mut scene = Scene::new("bundle");
    scene.cloths.push(Cloth::from_bundle("garment", bundle).unwrap());
    Stepper::on_cpu(scene, Options { threads: 1, ..Options::default() }).unwrap()
}

/// The largest distance of a vertex at rest from its place in the source, as a share of the diagonal, and the largest error of a normal.
pub fn rest_error(bundle: &Bundle) -> (f64, f64) {
    let mesh = RenderMesh::from_bundle(bundle).unwrap().unwrap();
    let (source, stepper) = (source(bundle), stepper(bundle));
    let mut vertices = Vec::new();
    stepper.wrap(0, &mesh, 1.0, &mut vertices).unwrap();
    assert_eq!(source.len(), vertices.len());
    let size = diagonal(source.iter().map(|s| s.0));
    let mut worst = (0.0f64, 0.0f64);
    for ((at, normal), vertex) in source.iter().zip(&vertices) {
        worst.0 = worst.0.max(distance(*at, &vertex.position) / size);
        if normal.iter().any(|x| *x != 0.0) {
            worst.1 = worst.1.max(distance(*normal, &vertex.normal));
        }
    }
    worst
}

/// Panics if vertices at one place in the source are not at one place, to the bit.
pub fn no_crack(name: &str, source: &[([f64; 3], [f64; 3])], vertices: &[RenderVertex], mesh: &RenderMesh) {
    let mut at: HashMap<[u64; 3], [u32; 4]> = HashMap::new();
    let mut shared = 0;
    for part in mesh.parts.iter().filter(|p| p.is_bound) {
        for v in part.vertices.clone() {
            let key = source[v].0.map(|x| (x + 0.0).to_bits());
            let bits = vertices[v].position.map(f32::to_bits);
            if let Some(first) = at.insert(key, bits) {
                shared += 1;
                assert_eq!(first, bits, "{name}: vertex {v}");
            }
        }
    }
    println!("{name}: {shared} vertices share their place with another one");
}
