//! Twin of shaders/blend.wgsl: vertices of a bound mesh between the skin and the cloth.

use crate::cloth::{Influence, Poses};
use crate::layout::{BlendRow, RenderVertex};

/// Moves the vertices of some rows, which are on the cloth; each row has as many `influences`. Every joint must have a pose, and every row
/// a vertex.
pub fn run(rows: &[BlendRow], influences: &[Influence], poses: &Poses<f32>, vertices: &mut [RenderVertex]) {
    let sets = influences.len() / rows.len().max(1);
    for (row, own) in rows.iter().zip(influences.chunks(sets.max(1))) {
        let vertex = &mut vertices[row.vertex as usize];
        *vertex = moved(row, own, poses, vertex);
    }
}

/// One of them.
fn moved(row: &BlendRow, own: &[Influence], poses: &Poses<f32>, cloth: &RenderVertex) -> RenderVertex {
    let each = || own.iter().flat_map(|i| i.joints.into_iter().zip(i.weights)).filter(|(_, w)| *w > 0.0);
    let blend = each().next().map(|_| poses.blend(each()));
    let at = blend.as_ref().map_or(row.rest, |blend| blend.place(row.rest));
    let turn = |v: [f32; 3]| blend.as_ref().map_or(v, |blend| blend.turn(v));
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
