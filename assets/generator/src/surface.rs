//! From a draped garment to vertices: seams split, normals, texture coordinates.

use crate::drape::normals;
use crate::math::{V2, V3};
use crate::panel::PanelMesh;
use crate::sew::Garment;

/// Triangles as they go into a file, with optional extras for each vertex.
#[derive(Default)]
pub struct Surface {
    /// Positions; the copies of a seam vertex are equal to the last bit.
    pub positions: Vec<[f32; 3]>,
    /// Unit normals, equal for all copies of a seam vertex.
    pub normals: Vec<[f32; 3]>,
    /// Panel coordinates scaled to 0..1, V down.
    pub uvs: Vec<[f32; 2]>,
    /// Counter-clockwise triangles.
    pub indices: Vec<u32>,
    /// The particle of each vertex.
    pub particle: Vec<usize>,
    /// How many metres one unit of texture is.
    pub metres_per_uv: f64,
}

/// Room between panels in the texture, in metres.
const MARGIN: f64 = 0.02;

/// Splits the garment at its seams.
pub fn surface(g: &Garment) -> Surface {
    // A grid of a hundredth of a millimetre: nothing visible is lost, and the files compress better.
    let x: Vec<V3> = g.x.iter().map(|p| p.map(|c| (c * 1e5).round() / 1e5)).collect();
    let normal = normals(g);
    let (corner, side) = pack(&g.panels);
    let mut s = Surface { metres_per_uv: side, ..Surface::default() };
    for ((m, of), at) in g.panels.iter().zip(&g.particle).zip(corner) {
        let base = s.positions.len();
        for (p, &i) in m.points.iter().zip(of) {
            s.positions.push(x[i].map(|c| c as f32));
            s.normals.push(normal[i].map(|c| c as f32));
            s.uvs.push([((p[0] + at[0]) / side) as f32, (1.0 - (p[1] + at[1]) / side) as f32]);
            s.particle.push(i);
        }
        s.indices.extend(m.triangles.iter().flatten().map(|&i| (base + i) as u32));
    }
    s
}

/// Lays the panels on shelves, tallest first: the shift of each panel, and the side of the square.
fn pack(panels: &[PanelMesh]) -> (Vec<V2>, f64) {
    let boxes: Vec<[V2; 2]> = panels
        .iter()
        .map(|m| {
            let fold = |f: fn(f64, f64) -> f64, from: f64| [0, 1].map(|k| m.points.iter().map(|p| p[k]).fold(from, f));
            [fold(f64::min, f64::MAX), fold(f64::max, f64::MIN)]
        })
        .collect();
    let size = |i: usize| [0, 1].map(|k| boxes[i][1][k] - boxes[i][0][k] + MARGIN);
    let mut order: Vec<usize> = (0..panels.len()).collect();
    order.sort_by(|&a, &b| size(b)[1].total_cmp(&size(a)[1]).then(a.cmp(&b)));
    let mut best: Option<(Vec<V2>, f64)> = None;
    // Try widths in centimetres; keep the smallest square.
    for width in (10..600).map(|cm| f64::from(cm) * 0.01) {
        let (mut x, mut y, mut shelf, mut right) = (MARGIN, MARGIN, 0.0f64, 0.0f64);
        let mut shift = vec![[0.0; 2]; panels.len()];
        for &i in &order {
            let [w, h] = size(i);
            if x > MARGIN && x + w > width {
                (x, y, shelf) = (MARGIN, y + shelf, 0.0);
            }
            shift[i] = [x - boxes[i][0][0], y - boxes[i][0][1]];
            x += w;
            shelf = shelf.max(h);
            right = right.max(x);
        }
        let side = right.max(y + shelf);
        if best.as_ref().is_none_or(|b| side < b.1) {
            best = Some((shift, side));
        }
    }
    best.unwrap_or_default()
}
