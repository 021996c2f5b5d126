//! Bundles with a mesh that is bound to their piece.

use gimage_bundle::manifest::RenderEntry;
use gimage_bundle::{Bundle, COORD, Image, MapKind, OFFSET, RENDER_FILE};

use super::source_mesh;

const IDENTITY: [f64; 16] = [1.0, 0.0, 0.0, 0.0, 0.0, 1.0, 0.0, 0.0, 0.0, 0.0, 1.0, 0.0, 0.0, 0.0, 0.0, 1.0];

/// A vertex: position, normal, tangent, then piece, u, v, and the offset; a piece of -1 for a vertex that is not bound.
pub struct Vertex {
    pub position: [f32; 3],
    pub normal: [f32; 3],
    pub tangent: [f32; 4],
    pub coord: [f32; 3],
    pub offset: [f32; 3],
}

/// A bundle of one piece of w x h texels, whose position and code `at` has, with a mesh of triangles between these vertices in their order. Springs are
/// as long as at rest.
pub fn bundle((w, h): (u32, u32), at: impl Fn(u32, u32) -> [f32; 4], vertices: &[Vertex]) -> Bundle {
    let mut bundle = Bundle::new("test");
    let piece = bundle.add_piece("cloth", w, h).unwrap();
    let image = |data: Vec<f32>| Image { width: w, height: h, channels: 4, data };
    bundle.insert(piece, MapKind::Position, image((0..w * h).flat_map(|k| at(k % w, k / w)).collect())).unwrap();
    let spring = |a: [u32; 2], b: [i64; 2]| {
        let inside = |x: i64, n: u32| u32::try_from(x).ok().filter(|x| *x < n);
        let Some((i, j)) = inside(b[0], w).zip(inside(b[1], h)) else { return 0.0 };
        let (p, q) = (at(a[0], a[1]), at(i, j));
        if p[3] == 0.0 || q[3] == 0.0 { 0.0 } else { (0..3).map(|c| (p[c] - q[c]).powi(2)).sum::<f32>().sqrt() }
    };
    let rest = (0..w * h).flat_map(|k| {
        let (i, j) = (k % w, k / w);
        [[1, 0], [0, 1], [1, 1], [1, -1]].map(|[x, y]| spring([i, j], [i64::from(i) + x, i64::from(j) + y]))
    });
    bundle.insert(piece, MapKind::Rest, image(rest.collect())).unwrap();
    bundle.count().unwrap();
    let column = |f: &dyn Fn(&Vertex) -> Vec<f32>| vertices.iter().flat_map(f).collect::<Vec<f32>>();
    bundle.render = Some(source_mesh::file(&[
        ("POSITION", 3, column(&|v| v.position.to_vec())),
        ("NORMAL", 3, column(&|v| v.normal.to_vec())),
        ("TANGENT", 4, column(&|v| v.tangent.to_vec())),
        (COORD, 3, column(&|v| v.coord.to_vec())),
        (OFFSET, 3, column(&|v| v.offset.to_vec())),
    ]));
    let length = |v: &Vertex| v.offset.iter().map(|x| f64::from(*x).powi(2)).sum::<f64>().sqrt();
    bundle.manifest.render = Some(RenderEntry {
        file: RENDER_FILE.into(),
        vertices: vertices.len() as u64,
        bound: vertices.iter().filter(|v| v.coord[0] >= 0.0).count() as u64,
        largest_offset: vertices.iter().map(length).fold(0.0, f64::max),
        transform: IDENTITY,
    });
    assert_eq!(gimage_bundle::validate(&bundle), []);
    bundle
}

/// A number of 0 to 1 that a rule makes of the index of a vertex.
pub fn share(k: usize, by: f32) -> f32 {
    (k as f32 * by).fract()
}

/// Vertices spread over a piece by a rule, the corners of the piece first; each seventh is not bound.
pub fn spread(count: usize) -> Vec<Vertex> {
    let vertex = |k: usize| {
        let place = [0.0, share(k, 0.618_034), share(k, 0.754_877_7)];
        let place = if k < 4 { [0.0, (k % 2) as f32, (k / 2) as f32] } else { place };
        let angle = 6.0 * share(k, 0.37);
        Vertex {
            position: [0.1, 0.2, k as f32 * 1e-3],
            normal: [0.0, angle.cos(), angle.sin()],
            tangent: [1.0, 0.0, 0.0, if k.is_multiple_of(2) { 1.0 } else { -1.0 }],
            coord: if k % 7 == 6 { [-1.0, 0.0, 0.0] } else { place },
            offset: [0.01 * share(k, 0.3), -0.01 * share(k, 0.7), 0.05 * share(k, 0.1)],
        }
    };
    (0..count).map(vertex).collect()
}

/// Triangles of a square of `cells` x `cells` quads over a piece, 1 mm in front of it, each with vertices of its own.
pub fn sheet(cells: u32) -> Vec<Vertex> {
    let vertex = |[i, j]: [u32; 2]| {
        let [u, v] = [i, j].map(|x| x as f32 / cells as f32);
        Vertex {
            position: [u, v, 0.0],
            normal: [0.0, 0.0, -1.0],
            tangent: [1.0, 0.0, 0.0, 1.0],
            coord: [0.0, u, v],
            offset: [0.0, 0.0, 0.001],
        }
    };
    let quads = (0..cells).flat_map(|j| (0..cells).map(move |i| [i, j]));
    let corners = |[i, j]: [u32; 2]| {
        let [a, b, c, d] = [[i, j], [i, j + 1], [i + 1, j + 1], [i + 1, j]];
        [a, b, c, a, c, d]
    };
    quads.flat_map(corners).map(vertex).collect()
}

/// A flag in the x-y plane of texels 5 cm apart, pinned along its upper edge.
pub fn flag_texel(i: u32, j: u32) -> [f32; 4] {
    [0.05 * i as f32, -0.05 * j as f32, 0.0, if j == 0 { -1.0 } else { 1.0 }]
}

/// A texel of a tube around y with a seam, of 13 columns, pinned along its upper edge.
pub fn tube_texel(i: u32, j: u32) -> [f32; 4] {
    let angle = std::f32::consts::TAU * (i % 12) as f32 / 12.0;
    let code = match i {
        0 => (j * 13 + 12 + 2) as f32,
        12 => (j * 13 + 2) as f32,
        _ => 1.0,
    };
    [0.2 * angle.cos(), -0.05 * j as f32, 0.2 * angle.sin(), if j == 0 { -code } else { code }]
}
