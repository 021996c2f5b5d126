//! Twin of shaders/draw.wgsl and its parts: corners of triangles, and the light on them. In f32 only: nothing is
//! measured on pictures.

use super::rows::ViewRow;
use crate::number::real::{V3, add, dot, scale, sub};

/// A corner as the vertex stage hands it on.
#[derive(Clone, Copy, Debug)]
pub struct Corner {
    pub at: V3<f32>,
    pub normal: V3<f32>,
    pub uv: [f32; 2],
    /// Linear red, green, blue and alpha; read for surfaces of the host only.
    pub color: [f32; 4],
}

/// The particles and texels of a cloth that is drawn.
pub struct Drawn<'a> {
    pub now: &'a [[f32; 4]],
    pub before: &'a [[f32; 4]],
    pub normals: &'a [[f32; 4]],
    pub holes: Option<&'a [u32]>,
    pub uv: Option<&'a [[f32; 2]]>,
}

/// The triangle below or above the diagonal of a quad, given as four particles from (i, j) by way of (i+1, j). Three
/// particles make one triangle, the one below.
pub fn triangle(quad: [usize; 4], there: [bool; 4], upper: bool) -> Option<[usize; 3]> {
    let [a, b, c, d] = quad;
    match (there, upper) {
        ([true, true, true, true], true) | ([true, true, true, false], false) => Some([a, b, c]),
        ([true, _, true, true], false) => Some([a, c, d]),
        ([false, true, true, true], false) => Some([b, c, d]),
        ([true, true, false, true], false) => Some([a, b, d]),
        _ => None,
    }
}

impl Drawn<'_> {
    /// Calls `draw` with the corners of every triangle of a grid.
    pub fn triangles(
        &self,
        first: usize,
        width: usize,
        height: usize,
        view: &ViewRow,
        mut draw: impl FnMut([Corner; 3]),
    ) {
        for quad in 0..(width - 1) * (height - 1) * 2 {
            let (upper, quad) = (quad % 2 == 1, quad / 2);
            let k = first + quad / (width - 1) * width + quad % (width - 1);
            let around = [k, k + 1, k + width + 1, k + width];
            let there = around.map(|k| self.now[k][3] >= 0.0);
            let hole = self.holes.is_some_and(|h| h[k] >> u32::from(upper) & 1 == 1);
            if let Some(t) = triangle(around, there, upper).filter(|_| !hole) {
                draw([0, 1, 2].map(|c| self.corner(t, c, view)));
            }
        }
    }

    fn corner(&self, t: [usize; 3], c: usize, view: &ViewRow) -> Corner {
        let k = t[c];
        let mixed = |c: usize| self.before[k][c] + (self.now[k][c] - self.before[k][c]) * view.fraction;
        let uv = self.uv.map_or([0.0; 2], |uv| {
            let far = [1, 2].map(|o| [0, 1].map(|c| (uv[t[o]][c] - uv[t[0]][c]).abs()));
            let far = far.as_flattened().iter().fold(0.0, |a: f32, b| a.max(*b));
            uv[if far > view.jump { t[0] } else { k }]
        });
        let [x, y, z, _] = self.normals[k];
        Corner { at: [0, 1, 2].map(mixed), normal: [x, y, z], uv, color: [1.0; 4] }
    }
}

/// The colour of a point of a surface, linear. `fade` is the distance at which it has become background, 0 for never.
pub fn fragment(view: &ViewRow, p: &Corner, is_front: bool, front: V3<f32>, back: V3<f32>, fade: f32) -> V3<f32> {
    let side = if is_front { 1.0 } else { -1.0 };
    let n = scale(p.normal, side / dot(p.normal, p.normal).sqrt().max(1e-9));
    let base = scale(if is_front { front } else { back }, checker(view, p.uv));
    let color = lit(view, base, n, p.at);
    if fade <= 0.0 {
        return color;
    }
    let d = sub(p.at, view.middle);
    let far = (dot(d, d).sqrt() / fade).clamp(0.0, 1.0);
    add(color, scale(sub(view.background, color), far * far * (3.0 - 2.0 * far)))
}

fn lit(view: &ViewRow, base: V3<f32>, n: V3<f32>, at: V3<f32>) -> V3<f32> {
    let d = sub(view.eye, at);
    let to_eye = scale(d, 1.0 / dot(d, d).sqrt().max(1e-9));
    let facing = dot(n, to_eye).clamp(0.0, 1.0);
    let sky = 0.32 + 0.12 * n[1];
    let lamp = 0.62 * dot(n, view.light).max(0.0);
    let edge = (1.0 - facing) * (1.0 - facing) * (1.0 - facing);
    add(scale(base, sky + lamp + 0.14 * facing), [0.05 * edge; 3])
}

fn checker(view: &ViewRow, uv: [f32; 2]) -> f32 {
    let cell = uv.map(|x| (x * view.tiles).floor());
    let odd = cell[0] + cell[1] - 2.0 * ((cell[0] + cell[1]) * 0.5).floor();
    1.0 - view.shade * odd
}

/// Linear light as sRGB, both 0 to 1.
pub fn encoded(linear: f32) -> f32 {
    let c = linear.clamp(0.0, 1.0);
    if c <= 0.003_130_8 { c * 12.92 } else { 1.055 * c.powf(1.0 / 2.4) - 0.055 }
}

/// sRGB as linear light.
pub fn decoded(srgb: f32) -> f32 {
    let c = srgb.clamp(0.0, 1.0);
    if c <= 0.040_45 { c / 12.92 } else { ((c + 0.055) / 1.055).powf(2.4) }
}
