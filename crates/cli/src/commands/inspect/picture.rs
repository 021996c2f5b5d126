//! The cloth at rest with the triangles that cross: all of it, and the deepest crossing from near.

use gimage_runtime::crossings::{Crossings, Place};
use gimage_runtime::draw::{Alpha, Camera, Facet, Paint, Software, View};
use gimage_runtime::{Cloth, Options, Scene, Stepper};

use crate::commands::png;
use crate::exit::Failure;

/// Pixels on a side of each of the two parts.
const SIDE: u32 = 640;
/// The same of pictures by which the side is chosen from which most of the crossing triangles is seen.
const TRIAL_SIDE: u32 = 96;
/// Directions that are tried around the upright axis, and their heights.
const AROUND: u32 = 12;
const HEIGHTS: [f32; 3] = [-0.6, 0.15, 0.9];
const FOV: f32 = 0.6;
const BACKGROUND: [f32; 3] = [0.957, 0.957, 0.949];
/// Share of the cloth that is drawn in the picture of all of it, so that triangles inside are seen.
const SHOWN_SHARE: f32 = 0.35;
/// Half the side of the near part, in mean edges of the triangles that cross there.
const NEAR_EDGES: f32 = 8.0;

/// Indices of the paints.
const CLOTH: usize = 0;
const CROSSING: usize = 1;

/// The picture as a PNG. `found` lists all pairs. Without any, the picture shows the cloth alone.
pub fn png_of(cloth: &Cloth, found: &Crossings) -> Result<Vec<u8>, Failure> {
    let canvas = Canvas::new(cloth, found)?;
    let all = canvas.part(canvas.bounds(), SHOWN_SHARE)?;
    let Some(first) = found.worst.first() else { return png::encode((SIDE, SIDE), &all) };
    let near = canvas.part(canvas.around(cloth, [first.first, first.second]), 1.0)?;
    let side = SIDE as usize;
    let rows = all.chunks_exact(side).zip(near.chunks_exact(side));
    let both: Vec<[u8; 4]> = rows.flat_map(|(a, b)| a.iter().chain(b)).copied().collect();
    png::encode((2 * SIDE, SIDE), &both)
}

/// The triangles, and what draws them.
struct Canvas {
    facets: Vec<Facet>,
    stepper: Stepper,
}

type Bounds = ([f32; 3], [f32; 3]);

impl Canvas {
    fn new(cloth: &Cloth, found: &Crossings) -> Result<Self, Failure> {
        let places = found.worst.iter().flat_map(|pair| [pair.first, pair.second]);
        let mut crossing: Vec<[u32; 3]> = places.filter_map(|place| place.corners(cloth)).collect();
        crossing.sort_unstable();
        crossing.dedup();
        let indices = cloth.indices();
        let facets = indices.as_chunks::<3>().0.iter().map(|triangle| {
            let paint = if crossing.binary_search(triangle).is_ok() { CROSSING } else { CLOTH };
            facet(triangle.map(|k| cloth.positions()[k as usize]), paint)
        });
        // A painter draws the scene of a stepper; this one is empty.
        let stepper = Stepper::on_cpu(Scene::new("crossings"), Options::default())?;
        Ok(Canvas { facets: facets.collect(), stepper })
    }

    fn bounds(&self) -> Bounds {
        let corners = self.facets.iter().flat_map(|facet| facet.corners);
        corners.fold(([f32::MAX; 3], [f32::MIN; 3]), |(low, high), p| {
            ([0, 1, 2].map(|c| low[c].min(p[c])), [0, 1, 2].map(|c| high[c].max(p[c])))
        })
    }

    /// A box around two triangles and what is near.
    fn around(&self, cloth: &Cloth, places: [Place; 2]) -> Bounds {
        let corners: Vec<[f32; 3]> = places
            .iter()
            .filter_map(|place| place.corners(cloth))
            .flatten()
            .map(|k| cloth.positions()[k as usize])
            .collect();
        let count = corners.len().max(1) as f32;
        let middle = [0, 1, 2].map(|c| corners.iter().map(|p| p[c]).sum::<f32>() / count);
        let length = |a: &[f32; 3], b: &[f32; 3]| (0..3).map(|c| (a[c] - b[c]).powi(2)).sum::<f32>().sqrt();
        let edges = corners.as_chunks::<3>().0.iter().flat_map(|[a, b, c]| [length(a, b), length(b, c), length(c, a)]);
        let half = NEAR_EDGES * edges.sum::<f32>() / count;
        (middle.map(|x| x - half), middle.map(|x| x + half))
    }

    /// A picture of a box from the side from which most of the crossing triangles is seen; cloth covers a share of its pixels.
    fn part(&self, bounds: Bounds, share: f32) -> Result<Vec<[u8; 4]>, Failure> {
        let trial = self.painter(TRIAL_SIDE, 1.0)?;
        let mut best = (0, [0.45, 0.32, 1.0]);
        for height in HEIGHTS {
            for k in 0..AROUND {
                let (s, c) = (std::f32::consts::TAU * k as f32 / AROUND as f32).sin_cos();
                let from = [s, height, c];
                let picture = trial.picture(&self.stepper, &view(bounds, from), 1.0)?;
                // Light makes red darker, but no other colour of it.
                let red = picture.iter().filter(|[r, g, ..]| u32::from(*r) > 2 * u32::from(*g)).count();
                if red > best.0 {
                    best = (red, from);
                }
            }
        }
        Ok(self.painter(SIDE, share)?.picture(&self.stepper, &view(bounds, best.1), 1.0)?)
    }

    fn painter(&self, side: u32, share: f32) -> Result<Software, Failure> {
        let mut painter = Software::new(side, side, 1)?;
        let plain = Paint::plain([0.62, 0.66, 0.72]);
        let [r, g, b, _] = plain.color;
        let cloth = if share < 1.0 { Paint { color: [r, g, b, share], alpha: Alpha::Blend, ..plain } } else { plain };
        painter.set_paints(vec![cloth, Paint::plain([0.9, 0.05, 0.05])]);
        painter.set_surface(self.facets.clone());
        Ok(painter)
    }
}

fn view((low, high): Bounds, from: [f32; 3]) -> View {
    let camera = Camera::framing(low, high, from, FOV, 1.0);
    View { background: BACKGROUND, ..View::new(&camera, 1.0) }
}

fn facet(corners: [[f32; 3]; 3], paint: usize) -> Facet {
    let [a, b, c] = corners;
    let (u, v) = ([0, 1, 2].map(|k| b[k] - a[k]), [0, 1, 2].map(|k| c[k] - a[k]));
    let normal = [u[1] * v[2] - u[2] * v[1], u[2] * v[0] - u[0] * v[2], u[0] * v[1] - u[1] * v[0]];
    Facet { corners, normals: [normal; 3], uv: [[0.0; 2]; 3], colors: [[1.0; 4]; 3], paint }
}
