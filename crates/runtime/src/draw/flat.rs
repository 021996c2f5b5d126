//! Triangles on a picture: clipping, coverage and colour. Twin of what a device does between the two stages of shaders/draw.wgsl, and of
//! the paints of shaders/draw_surface.wgsl.

use super::ground::{Ground, Shadow};
use super::raster::{Corner, fragment};
use super::rows::ViewRow;
use super::surface::{Alpha, Paint};
use crate::number::real::{V3, add, scale};

/// Samples of a pixel, from its upper left corner.
pub const SAMPLES: [[f32; 2]; 4] = [[0.25, 0.25], [0.75, 0.25], [0.25, 0.75], [0.75, 0.75]];
/// The order in which samples of 4 x 4 pixels are filled as alpha rises (B. E. Bayer, 1973).
const DITHER: [[u8; 4]; 4] = [[0, 8, 2, 10], [12, 4, 14, 6], [3, 11, 1, 9], [15, 7, 13, 5]];

/// A triangle's corners on the picture: x, y \[pixels\], depth and 1/w.
pub struct Flat {
    at: [[f32; 4]; 3],
    corners: [Corner; 3],
    is_front: bool,
    shade: usize,
    /// Of the texture.
    level: usize,
}

/// The colours of many triangles.
pub struct Shade<'a> {
    pub view: ViewRow,
    pub front: V3<f32>,
    pub back: V3<f32>,
    pub fade: f32,
    pub kind: Kind<'a>,
}

/// A drawable of some kind.
pub enum Kind<'a> {
    /// A cloth or a collider.
    Plain,
    /// A surface of the host.
    Painted(&'a Paint),
    /// The ground, or a half-space in its place.
    Ground(&'a Ground),
    Floor,
}

/// Depth and linear colour of the samples of a pixel.
pub type Samples = [(f32, V3<f32>); 4];

/// Puts a triangle on a picture of width and height; the part nearer than the near plane is clipped away.
pub fn flatten(t: [Corner; 3], (index, shade): (usize, &Shade), size: [f32; 2], flats: &mut Vec<Flat>) {
    let view = &shade.view;
    let clip =
        t.map(|c| [0, 1, 2, 3].map(|r| (0..3).map(|k| view.clip[k][r] * c.at[k]).sum::<f32>() + view.clip[3][r]));
    let inside = clip.map(|p| p[2] >= 0.0 && p[3] > 0.0);
    if clip.as_flattened().iter().any(|x| !x.is_finite()) || inside == [false; 3] {
        return;
    }
    let mut polygon = Vec::with_capacity(4);
    for (k, next) in [(0, 1), (1, 2), (2, 0)] {
        if inside[k] {
            polygon.push((clip[k], t[k]));
        }
        if inside[k] != inside[next] {
            let s = clip[k][2] / (clip[k][2] - clip[next][2]);
            let on = [0, 1, 2, 3].map(|c| clip[k][c] + (clip[next][c] - clip[k][c]) * s);
            let mut w = [0.0; 3];
            (w[k], w[next]) = (1.0 - s, s);
            polygon.push((on, mixed(&t, w)));
        }
    }
    for k in 2..polygon.len() {
        let three = [&polygon[0], &polygon[k - 1], &polygon[k]];
        let at = three.map(|(p, _)| {
            let by = 1.0 / p[3].max(1e-12);
            let (x, y) = (0.5 + 0.5 * p[0] * by, 0.5 - 0.5 * p[1] * by);
            [x * size[0], y * size[1], p[2] * by, by]
        });
        // y goes down: counter-clockwise triangles have a negative area here.
        let area = twice_area(at[0], at[1], at[2]);
        if area != 0.0 && area.is_finite() {
            let corners = three.map(|(_, c)| *c);
            let level = level(&shade.kind, &corners, area.abs());
            flats.push(Flat { at, corners, is_front: area < 0.0, shade: index, level });
        }
    }
}

/// The level of the texture for a triangle that covers half of `area` pixels.
fn level(kind: &Kind, corners: &[Corner; 3], area: f32) -> usize {
    let Kind::Painted(Paint { texture: Some(texture), .. }) = kind else { return 0 };
    let [a, b, c] = [0, 1, 2].map(|k| [corners[k].uv[0], corners[k].uv[1], 0.0, 0.0]);
    texture.level(twice_area(a, b, c).abs(), area * SAMPLES.len() as f32)
}

/// Colours the samples of rows from `top` that a triangle covers and is nearest to.
pub fn cover(
    flat: &Flat,
    shades: &[Shade],
    shadow: Option<&Shadow>,
    (top, width): (usize, usize),
    all: &mut [Samples],
) {
    let [a, b, c] = flat.at;
    let shade = &shades[flat.shade];
    let range = |axis: usize, from: usize, count: usize| {
        let low = a[axis].min(b[axis]).min(c[axis]).floor() - from as f32;
        let high = a[axis].max(b[axis]).max(c[axis]).ceil() - from as f32;
        low.clamp(0.0, count as f32) as usize..high.clamp(0.0, count as f32) as usize
    };
    let by = 1.0 / twice_area(a, b, c);
    for row in range(1, top, all.len() / width) {
        for column in range(0, 0, width) {
            for (s, [dx, dy]) in SAMPLES.iter().enumerate() {
                let p = [column as f32 + dx, (top + row) as f32 + dy, 0.0, 0.0];
                let w = [twice_area(b, c, p) * by, twice_area(c, a, p) * by, twice_area(a, b, p) * by];
                if w.iter().any(|w| *w < 0.0) {
                    continue;
                }
                let depth = w[0] * a[2] + w[1] * b[2] + w[2] * c[2];
                let sample = &mut all[row * width + column][s];
                if depth >= sample.0 {
                    continue;
                }
                let weights = [w[0] * a[3], w[1] * b[3], w[2] * c[3]];
                let sum = 1.0 / (weights[0] + weights[1] + weights[2]);
                let corner = mixed(&flat.corners, weights.map(|w| w * sum));
                let threshold = f32::from(DITHER[(top + row) % 4][column % 4] + 16 * s as u8) / 64.0;
                if let Some(color) = shade.color(&corner, flat, shadow, threshold) {
                    *sample = (depth, color);
                }
            }
        }
    }
}

impl Shade<'_> {
    /// The linear colour at a point; `None` where alpha leaves it out.
    fn color(&self, p: &Corner, flat: &Flat, shadow: Option<&Shadow>, threshold: f32) -> Option<V3<f32>> {
        let lit = |front: V3<f32>, back: V3<f32>| fragment(&self.view, p, flat.is_front, front, back, self.fade);
        match &self.kind {
            Kind::Plain => Some(lit(self.front, self.back)),
            Kind::Ground(ground) => Some(ground.color(&self.view, p.at, shadow)),
            Kind::Floor => {
                let light = shadow.map_or(1.0, |s| s.light(p.at));
                Some(scale(lit(self.front, self.back), light))
            }
            Kind::Painted(paint) => {
                let texel = paint.texture.as_ref().map_or([1.0; 4], |t| t.at(p.uv, flat.level, paint.wrap));
                let [r, g, b, a] = [0, 1, 2, 3].map(|c| paint.color[c] * texel[c] * p.color[c]);
                let is_drawn = match paint.alpha {
                    Alpha::Opaque => true,
                    Alpha::Mask(cutoff) => a >= cutoff,
                    Alpha::Blend => a > threshold,
                };
                // A surface has no pattern of its own.
                let plain = Corner { uv: [0.0; 2], ..*p };
                let color = || fragment(&self.view, &plain, flat.is_front, [r, g, b], [r, g, b], self.fade);
                is_drawn.then(color)
            }
        }
    }
}

fn twice_area(a: [f32; 4], b: [f32; 4], c: [f32; 4]) -> f32 {
    (b[0] - a[0]) * (c[1] - a[1]) - (b[1] - a[1]) * (c[0] - a[0])
}

fn mixed(t: &[Corner; 3], w: [f32; 3]) -> Corner {
    let three = |get: fn(&Corner) -> V3<f32>| {
        add(add(scale(get(&t[0]), w[0]), scale(get(&t[1]), w[1])), scale(get(&t[2]), w[2]))
    };
    let uv = [0, 1].map(|c| t[0].uv[c] * w[0] + t[1].uv[c] * w[1] + t[2].uv[c] * w[2]);
    let color = [0, 1, 2, 3].map(|c| t[0].color[c] * w[0] + t[1].color[c] * w[1] + t[2].color[c] * w[2]);
    Corner { at: three(|c| c.at), normal: three(|c| c.normal), uv, color }
}
