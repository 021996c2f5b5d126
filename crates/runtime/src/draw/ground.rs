//! A ground that catches a soft shadow.

use super::View;
use super::rows::ViewRow;
use crate::number::real::V3;

/// A level ground under a scene: the colour of the background, a little darker below the scene, with a soft shadow. An upright half-space of the
/// scene takes its place and gets the shadow.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Ground {
    /// Its y \[m\].
    pub height: f32,
    /// x and z of its middle \[m\].
    pub middle: [f32; 2],
    /// Where it has become background \[m\].
    pub radius: f32,
}

/// Cells on a side of a shadow.
const CELLS: usize = 256;
/// Cells beside it, for what the blur spreads.
const EDGE: usize = 40;
/// Shadows of near, middle and far parts: where they end as a share of the height of the scene, and the radius of their blur \[cells\].
const LAYERS: [(f32, usize); 3] = [(0.06, 2), (0.3, 6), (f32::INFINITY, 12)];
/// Light that a full shadow takes away, and the ground below the scene.
const DARK: f32 = 0.5;
const SHADE: f32 = 0.06;

/// The shadow of a scene on a ground, as a picture seen from above.
pub struct Shadow {
    low: [f32; 2],
    cell: f32,
    /// Share of the light that is taken away, 0 to 1.
    cells: Vec<f32>,
}

impl Ground {
    /// Two triangles, from -1 to 1 times the radius around the middle; none for an eye below the ground.
    pub(super) fn triangles(&self, view: &View) -> Vec<[V3<f32>; 3]> {
        let [x, z] = self.middle;
        let corner = |a: f32, b: f32| [x + a * self.radius, self.height, z + b * self.radius];
        let [a, b, c, d] = [corner(-1.0, -1.0), corner(-1.0, 1.0), corner(1.0, 1.0), corner(1.0, -1.0)];
        if view.eye[1] > self.height { vec![[a, b, c], [a, c, d]] } else { Vec::new() }
    }

    /// Linear colour at a point.
    pub(super) fn color(&self, view: &ViewRow, at: V3<f32>, shadow: Option<&Shadow>) -> V3<f32> {
        let far = (at[0] - self.middle[0]).hypot(at[2] - self.middle[1]) / self.radius.max(1e-6);
        let near = 1.0 - far.clamp(0.0, 1.0);
        let near = near * near * (3.0 - 2.0 * near);
        let dark = (1.0 - SHADE * near) * (1.0 - near * (1.0 - shadow.map_or(1.0, |s| s.light(at))));
        view.background.map(|c| c * dark)
    }
}

impl Shadow {
    /// The shadow of triangles on the level `height` in a lamp high above that stands on the side of the light of the view.
    pub(super) fn new(triangles: &[[V3<f32>; 3]], height: f32, view: &ViewRow) -> Option<Self> {
        let lean = [0.35 * view.light[0], 0.35 * view.light[2]];
        let onto = |p: V3<f32>| {
            let up = (p[1] - height).max(0.0);
            [p[0] - lean[0] * up, p[2] - lean[1] * up]
        };
        let finite = |t: &&[V3<f32>; 3]| t.as_flattened().iter().all(|x| x.is_finite());
        let (mut low, mut high, mut top) = ([f32::INFINITY; 2], [f32::NEG_INFINITY; 2], 0.0f32);
        for p in triangles.iter().filter(finite).flatten() {
            let q = onto(*p);
            low = [0, 1].map(|c| low[c].min(q[c]));
            high = [0, 1].map(|c| high[c].max(q[c]));
            top = top.max(p[1] - height);
        }
        let size = (high[0] - low[0]).max(high[1] - low[1]);
        if !(size.is_finite() && size > 0.0) {
            return None;
        }
        let cell = size / (CELLS - 2 * EDGE) as f32;
        let low = low.map(|x| x - EDGE as f32 * cell);
        let mut layers = LAYERS.map(|_| vec![0.0f32; CELLS * CELLS]);
        for t in triangles.iter().filter(finite) {
            let up = t.iter().map(|p| p[1] - height).sum::<f32>() / 3.0;
            let layer = LAYERS.iter().position(|(end, _)| up <= end * top).unwrap_or(LAYERS.len() - 1);
            fill(t.map(|p| [0, 1].map(|c| (onto(p)[c] - low[c]) / cell)), &mut layers[layer]);
        }
        let mut cells = vec![1.0f32; CELLS * CELLS];
        for (mut layer, (_, radius)) in layers.into_iter().zip(LAYERS) {
            (0..3).for_each(|_| layer = blurred(&blurred(&layer, radius), radius));
            cells.iter_mut().zip(&layer).for_each(|(light, dark)| *light *= 1.0 - dark);
        }
        cells.iter_mut().for_each(|light| *light = DARK * (1.0 - *light));
        Some(Shadow { low, cell, cells })
    }

    /// The light at a point, 1 where there is no shadow.
    pub(super) fn light(&self, at: V3<f32>) -> f32 {
        let [x, y] = [(at[0] - self.low[0]) / self.cell - 0.5, (at[2] - self.low[1]) / self.cell - 0.5];
        let inside = |x: f32| x >= 0.0 && x < (CELLS - 1) as f32;
        if !inside(x) || !inside(y) {
            return 1.0;
        }
        let (i, j) = (x as usize, y as usize);
        let (s, t) = (x - i as f32, y - j as f32);
        let row = |j: usize| self.cells[j * CELLS + i] * (1.0 - s) + self.cells[j * CELLS + i + 1] * s;
        1.0 - (row(j) * (1.0 - t) + row(j + 1) * t)
    }
}

/// Sets the cells whose middles a triangle covers, and those of its corners.
fn fill(t: [[f32; 2]; 3], cells: &mut [f32]) {
    let cell = |x: f32| x.clamp(0.0, (CELLS - 1) as f32) as usize;
    t.iter().for_each(|p| cells[cell(p[1]) * CELLS + cell(p[0])] = 1.0);
    let twice = |a: [f32; 2], b: [f32; 2], c: [f32; 2]| (b[0] - a[0]) * (c[1] - a[1]) - (b[1] - a[1]) * (c[0] - a[0]);
    let area = twice(t[0], t[1], t[2]);
    let range = |axis: usize| {
        let low = t.iter().map(|p| p[axis]).fold(f32::INFINITY, f32::min);
        let high = t.iter().map(|p| p[axis]).fold(f32::NEG_INFINITY, f32::max);
        cell(low)..=cell(high)
    };
    for j in range(1) {
        for i in range(0) {
            let p = [i as f32 + 0.5, j as f32 + 0.5];
            let w = [twice(t[1], t[2], p), twice(t[2], t[0], p), twice(t[0], t[1], p)];
            if w.iter().all(|w| w * area >= 0.0) {
                cells[j * CELLS + i] = 1.0;
            }
        }
    }
}

/// The mean over `radius` cells on both sides in each row, with rows and columns swapped: twice is a box blur.
fn blurred(cells: &[f32], radius: usize) -> Vec<f32> {
    let mut out = vec![0.0; CELLS * CELLS];
    let by = 1.0 / (2 * radius + 1) as f32;
    for (j, row) in cells.chunks_exact(CELLS).enumerate() {
        let mut sum: f32 = row[..radius].iter().sum();
        for i in 0..CELLS {
            sum += row.get(i + radius).copied().unwrap_or(0.0);
            out[i * CELLS + j] = (sum * by).clamp(0.0, 1.0);
            sum -= if i >= radius { row[i - radius] } else { 0.0 };
        }
    }
    out
}
