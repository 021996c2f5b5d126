//! The same pictures on the CPU, for machines without an adapter. Four samples per pixel, each lit by itself.

use std::collections::{BTreeMap, BTreeSet};

use super::raster::{Corner, Drawn, decoded, encoded, fragment};
use super::rows::{BodyRow, ViewRow};
use super::{Facet, Look, SolidLook, View, mesh, turned};
use crate::collider::Collider;
use crate::cpu::rows::Threads;
use crate::error::{Error, Result, check};
use crate::handle::ClothRef;
use crate::look::Looks;
use crate::number::real::{add, scale, xyz};
use crate::stepper::Stepper;

/// Most pixels on a side of a picture.
pub const MAX_SIDE: u32 = 8192;
/// Rows of pixels that are worked on at a time.
const BAND: usize = 16;
/// Samples of a pixel, from its upper left corner.
const SAMPLES: [[f32; 2]; 4] = [[0.25, 0.25], [0.75, 0.25], [0.25, 0.75], [0.75, 0.75]];

/// A painter of pictures of one size.
pub struct Software {
    width: u32,
    height: u32,
    threads: Threads,
    looks: Looks,
    hidden: BTreeSet<usize>,
    bare: BTreeSet<usize>,
    facets: Vec<Facet>,
    /// How colliders are drawn.
    pub solid_look: SolidLook,
}

/// A triangle's corners on the picture: x, y \[pixels\], depth and 1/w.
struct Flat {
    at: [[f32; 4]; 3],
    corners: [Corner; 3],
    is_front: bool,
    paint: usize,
}

/// Numbers that many triangles share.
struct Paint {
    view: ViewRow,
    front: [f32; 3],
    back: [f32; 3],
    fade: f32,
}

impl Software {
    /// Errors on sides outside 1 to 8192 and where no threads can be started; `threads` as in [`crate::Options`].
    pub fn new(width: u32, height: u32, threads: usize) -> Result<Self> {
        for side in [width, height] {
            check("a side of a picture [pixels]", side.into(), "1 to 8192", |s| {
                (1.0..=f64::from(MAX_SIDE)).contains(&s)
            })?;
        }
        let (threads, solid_look) = (Threads::new(threads)?, SolidLook::default());
        let (looks, hidden, bare, facets) = Default::default();
        Ok(Software { width, height, threads, looks, hidden, bare, facets, solid_look })
    }

    /// How a cloth is drawn from now on; an index is that of the cloth when it is drawn.
    pub fn set_look(&mut self, cloth: impl Into<ClothRef>, look: Look) {
        self.looks.set(cloth.into(), look);
    }

    /// Whether the collider of an index is left out of pictures from now on, as a surface stands for it.
    pub fn hide_collider(&mut self, index: usize, hidden: bool) {
        if hidden {
            self.hidden.insert(index)
        } else {
            self.hidden.remove(&index)
        };
    }

    /// Whether the cloth of an index is left out of pictures from now on, as a surface stands for it.
    pub fn hide_cloth(&mut self, index: usize, hidden: bool) {
        if hidden {
            self.bare.insert(index)
        } else {
            self.bare.remove(&index)
        };
    }

    /// Draws these triangles from now on, in place of those of the last call.
    pub fn set_surface(&mut self, facets: Vec<Facet>) {
        self.facets = facets;
    }

    /// The picture, a row after the other from the top, sRGB and opaque. Takes a stepper on the CPU backend; `fraction`
    /// as in [`crate::Progress`]. Errors on other steppers and on texture coordinates that do not fit their cloth. Time is
    /// linear in pixels and triangles; the result does not depend on the threads.
    pub fn picture(&self, stepper: &Stepper, view: &View, fraction: f32) -> Result<Vec<[u8; 4]>> {
        let (mut flats, mut paints) = (Vec::new(), Vec::new());
        for (index, cloth) in stepper.scene().cloths.iter().enumerate().filter(|(c, _)| !self.bare.contains(c)) {
            let lists = (stepper.positions(index), stepper.previous(index), stepper.normals(index));
            let (Some(now), Some(before), Some(normals)) = lists else { return Err(Error::GpuOnly("Software")) };
            let look = self.looks.of(index, stepper.handles()[index]);
            let uv = look.uv.as_deref();
            if let Some(found) = uv.map(<[_]>::len).filter(|n| *n != cloth.len()) {
                let (cloth, expected) = (cloth.name().to_owned(), cloth.len());
                return Err(Error::Length { cloth, what: "texture coordinates", found, expected });
            }
            let row = ViewRow::cloth(view, &look, look.jump(cloth.grids()), fraction);
            let drawn = Drawn { now, before, normals, holes: stepper.holes(index), uv };
            for grid in cloth.grids() {
                let (first, width, height) = (grid.first as usize, grid.width as usize, grid.height as usize);
                drawn.triangles(first, width, height, &row, |t| self.flatten(t, &row, paints.len(), &mut flats));
            }
            let [front, back] = [row.front, row.back].map(xyz);
            paints.push(Paint { view: row, front, back, fade: 0.0 });
        }
        let shown = stepper.scene().colliders.iter().enumerate().filter(|(c, _)| !self.hidden.contains(c));
        shown.for_each(|(_, collider)| self.solid(collider, view, &mut flats, &mut paints));
        self.surface(view, &mut flats, &mut paints);
        Ok(self.paint(&flats, &paints, view))
    }

    fn solid(&self, collider: &Collider, view: &View, flats: &mut Vec<Flat>, paints: &mut Vec<Paint>) {
        let (row, body) = (ViewRow::solids(view), BodyRow::new(collider, self.solid_look.color));
        for triangle in mesh::of(&collider.shape, self.solid_look.inset).chunks_exact(3) {
            let corner = |v: &mesh::Vertex| Corner {
                at: add(turned(body.rotation, xyz(v[0])), body.center),
                normal: turned(body.rotation, xyz(v[1])),
                uv: [v[0][3], v[1][3]],
            };
            let t = [corner(&triangle[0]), corner(&triangle[1]), corner(&triangle[2])];
            self.flatten(t, &row, paints.len(), flats);
        }
        let color = xyz(body.color);
        paints.push(Paint { view: row, front: color, back: color, fade: body.fade });
    }

    fn surface(&self, view: &View, flats: &mut Vec<Flat>, paints: &mut Vec<Paint>) {
        let row = ViewRow::solids(view);
        let mut known = BTreeMap::new();
        for facet in &self.facets {
            let paint = *known.entry(facet.color.map(f32::to_bits)).or_insert_with(|| {
                let color = facet.color.map(decoded);
                paints.push(Paint { view: row, front: color, back: color, fade: 0.0 });
                paints.len() - 1
            });
            let corner = |c: usize| Corner { at: facet.corners[c], normal: facet.normals[c], uv: [0.0; 2] };
            self.flatten([0, 1, 2].map(corner), &row, paint, flats);
        }
    }

    /// Puts a triangle on the picture; what is nearer than the near plane is clipped away.
    fn flatten(&self, t: [Corner; 3], view: &ViewRow, paint: usize, flats: &mut Vec<Flat>) {
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
                polygon.push((
                    on,
                    mixed(&t, {
                        let mut w = [0.0; 3];
                        (w[k], w[next]) = (1.0 - s, s);
                        w
                    }),
                ));
            }
        }
        for k in 2..polygon.len() {
            let three = [&polygon[0], &polygon[k - 1], &polygon[k]];
            let at = three.map(|(p, _)| {
                let by = 1.0 / p[3].max(1e-12);
                let (x, y) = (0.5 + 0.5 * p[0] * by, 0.5 - 0.5 * p[1] * by);
                [x * self.width as f32, y * self.height as f32, p[2] * by, by]
            });
            // y goes down: counter-clockwise triangles have a negative area here.
            let area = twice_area(at[0], at[1], at[2]);
            if area != 0.0 && area.is_finite() {
                flats.push(Flat { at, corners: three.map(|(_, c)| *c), is_front: area < 0.0, paint });
            }
        }
    }

    fn paint(&self, flats: &[Flat], paints: &[Paint], view: &View) -> Vec<[u8; 4]> {
        let width = self.width as usize;
        let mut pixels = vec![[0, 0, 0, 255]; width * self.height as usize];
        let background = view.background.map(decoded);
        self.threads.chunks(&mut pixels, width * BAND, |band, pixels| {
            let top = band * BAND;
            let mut samples = vec![[(f32::INFINITY, background); 4]; pixels.len()];
            for flat in flats {
                cover(flat, &paints[flat.paint], top, width, &mut samples);
            }
            for (pixel, samples) in pixels.iter_mut().zip(&samples) {
                for (c, number) in pixel[..3].iter_mut().enumerate() {
                    let light = samples.iter().map(|s| s.1[c].clamp(0.0, 1.0)).sum::<f32>() / 4.0;
                    *number = (encoded(light) * 255.0 + 0.5) as u8;
                }
            }
        });
        pixels
    }
}

type Samples = [(f32, [f32; 3]); 4];

/// Colours the samples of rows from `top` that a triangle covers and is nearest to.
fn cover(flat: &Flat, paint: &Paint, top: usize, width: usize, samples: &mut [Samples]) {
    let [a, b, c] = flat.at;
    let range = |axis: usize, from: usize, count: usize| {
        let low = a[axis].min(b[axis]).min(c[axis]).floor() - from as f32;
        let high = a[axis].max(b[axis]).max(c[axis]).ceil() - from as f32;
        low.clamp(0.0, count as f32) as usize..high.clamp(0.0, count as f32) as usize
    };
    let by = 1.0 / twice_area(a, b, c);
    for row in range(1, top, samples.len() / width) {
        for column in range(0, 0, width) {
            for (s, [dx, dy]) in SAMPLES.iter().enumerate() {
                let p = [column as f32 + dx, (top + row) as f32 + dy, 0.0, 0.0];
                let w = [twice_area(b, c, p) * by, twice_area(c, a, p) * by, twice_area(a, b, p) * by];
                if w.iter().any(|w| *w < 0.0) {
                    continue;
                }
                let depth = w[0] * a[2] + w[1] * b[2] + w[2] * c[2];
                let sample = &mut samples[row * width + column][s];
                if depth >= sample.0 {
                    continue;
                }
                let weights = [w[0] * a[3], w[1] * b[3], w[2] * c[3]];
                let sum = 1.0 / (weights[0] + weights[1] + weights[2]);
                let corner = mixed(&flat.corners, weights.map(|w| w * sum));
                let color = fragment(&paint.view, &corner, flat.is_front, paint.front, paint.back, paint.fade);
                *sample = (depth, color);
            }
        }
    }
}

fn twice_area(a: [f32; 4], b: [f32; 4], c: [f32; 4]) -> f32 {
    (b[0] - a[0]) * (c[1] - a[1]) - (b[1] - a[1]) * (c[0] - a[0])
}

fn mixed(t: &[Corner; 3], w: [f32; 3]) -> Corner {
    let three = |get: fn(&Corner) -> [f32; 3]| {
        add(add(scale(get(&t[0]), w[0]), scale(get(&t[1]), w[1])), scale(get(&t[2]), w[2]))
    };
    let uv = [0, 1].map(|c| t[0].uv[c] * w[0] + t[1].uv[c] * w[1] + t[2].uv[c] * w[2]);
    Corner { at: three(|c| c.at), normal: three(|c| c.normal), uv }
}
