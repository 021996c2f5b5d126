//! Twin of shaders/blend.wgsl: vertices of a bound mesh between the skin and the cloth.

use crate::cloth::{Influence, Rows};
use crate::layout::{BlendRow, RenderVertex};

/// Moves the vertices of some rows, which are on the cloth; each row has as many `influences`. Every joint must have a matrix, and every row
/// a vertex.
pub fn run(rows: &[BlendRow], influences: &[Influence], matrices: &[Rows], vertices: &mut [RenderVertex]) {
    let sets = influences.len() / rows.len().max(1);
    for (row, own) in rows.iter().zip(influences.chunks(sets.max(1))) {
        let vertex = &mut vertices[row.vertex as usize];
        *vertex = moved(row, own, matrices, vertex);
    }
}

/// One of them.
fn moved(row: &BlendRow, own: &[Influence], matrices: &[Rows], cloth: &RenderVertex) -> RenderVertex {
    let mut blend = [[0.0f32; 4]; 3];
    let mut follows = false;
    for (joint, weight) in own.iter().flat_map(|i| i.joints.iter().zip(i.weights)).filter(|(_, w)| *w > 0.0) {
        follows = true;
        for (sum, from) in blend.iter_mut().zip(&matrices[*joint as usize]) {
            sum.iter_mut().zip(from).for_each(|(sum, x)| *sum += x * weight);
        }
    }
    let turn = |v: [f32; 3]| if follows { blend.map(|r| r[0] * v[0] + r[1] * v[1] + r[2] * v[2]) } else { v };
    let at = turn(row.rest);
    let at = if follows { [0, 1, 2].map(|k| at[k] + blend[k][3]) } else { at };
    let [tx, ty, tz, _] = row.tangent;
    let ([px, py, pz, _], [nx, ny, nz, _]) = (cloth.position, cloth.normal);
    let [cx, cy, cz, sign] = cloth.tangent;
    let [x, y, z] = mix(at, [px, py, pz], row.share);
    let n = unit(mix(unit(turn(row.normal)), [nx, ny, nz], row.share));
    let t = unit(mix(unit(turn([tx, ty, tz])), [cx, cy, cz], row.share));
    RenderVertex { position: [x, y, z, 1.0], normal: [n[0], n[1], n[2], 0.0], tangent: [t[0], t[1], t[2], sign] }
}

fn mix(skin: [f32; 3], cloth: [f32; 3], share: f32) -> [f32; 3] {
    if share > 0.0 { [0, 1, 2].map(|k| skin[k] + (cloth[k] - skin[k]) * share) } else { skin }
}

fn unit(v: [f32; 3]) -> [f32; 3] {
    let length = (v[0] * v[0] + v[1] * v[1] + v[2] * v[2]).sqrt();
    if length > 0.0 { v.map(|x| x * (1.0 / length)) } else { [0.0; 3] }
}
