//! A limb as a body, and how deep cloth is inside of it.

use gimage_runtime::Cloth;
use parry3d_f64::math::{Pose, Vector};
use parry3d_f64::query::PointQuery;
use parry3d_f64::shape::TriMesh;

pub const IDENTITY: [f32; 16] = [1.0, 0.0, 0.0, 0.0, 0.0, 1.0, 0.0, 0.0, 0.0, 0.0, 1.0, 0.0, 0.0, 0.0, 0.0, 1.0];
pub const THICKNESS: f32 = 0.003;

/// A closed tube along y from `top` down to `bottom`, with `around` vertices per ring and rounded ends.
pub fn limb(radius: f32, [top, bottom]: [f32; 2], around: u32, rings: u32) -> (Vec<[f32; 3]>, Vec<[u32; 3]>) {
    let (mut positions, mut triangles) = (Vec::new(), Vec::new());
    for j in 0..rings {
        let t = j as f32 / (rings - 1) as f32;
        let r = radius * (1.0 - (2.0 * t - 1.0).powi(8)).max(0.04).sqrt();
        for i in 0..around {
            let a = std::f32::consts::TAU * i as f32 / around as f32;
            positions.push([r * a.cos(), top + (bottom - top) * t, r * a.sin()]);
        }
    }
    let at = |i: u32, j: u32| j * around + i % around;
    for (i, j) in (0..rings - 1).flat_map(|j| (0..around).map(move |i| (i, j))) {
        triangles.extend([[at(i, j), at(i + 1, j), at(i, j + 1)], [at(i + 1, j), at(i + 1, j + 1), at(i, j + 1)]]);
    }
    for (j, y) in [(0, top), (rings - 1, bottom)] {
        let middle = positions.len() as u32;
        positions.push([0.0, y, 0.0]);
        let cap = |i| if j == 0 { [middle, at(i + 1, j), at(i, j)] } else { [middle, at(i, j), at(i + 1, j)] };
        triangles.extend((0..around).map(cap));
    }
    (positions, triangles)
}

/// How deep \[m\] the deepest free particle is inside, and how far the nearest one is outside.
pub fn depth(mesh: &TriMesh, cloth: &Cloth, positions: &[[f32; 4]]) -> [f64; 2] {
    let mut out = [0.0, f64::INFINITY];
    for p in positions.iter().zip(cloth.particles()).filter(|x| x.1.exists() && !x.1.is_pinned()).map(|x| x.0) {
        let p = Vector::new(p[0].into(), p[1].into(), p[2].into());
        let found = mesh.project_point(&Pose::IDENTITY, p, false);
        let far = (found.point - p).length();
        if found.is_inside { out[0] = f64::max(out[0], far) } else { out[1] = f64::min(out[1], far) }
    }
    out
}
