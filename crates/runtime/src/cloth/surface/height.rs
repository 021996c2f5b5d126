//! How high points are above a surface.

use gimage_bundle::Winding;

use super::{BodySurface, NONE, On, normal, on_triangle, vertex_normals};
use crate::cloth::{Poses, Rows, Skinning};
use crate::number::real::{V3, add, cast, cross, dot, scale, sub};

/// A point nearer \[m\] to the surface than this has no direction from it.
const ON_SURFACE_M: f64 = 1e-9;
/// The cosine of the angle from the normal beyond which a point beside a border has no surface below it.
const BESIDE_COSINE: f64 = 0.7;

/// A surface somewhere: its vertices \[m\] and their normals, weighed by angle, of any length.
pub struct Posed<'a> {
    surface: &'a BodySurface,
    at: Vec<V3<f64>>,
    normals: Vec<V3<f64>>,
    bounds: Vec<[V3<f64>; 2]>,
}

/// The point of a surface that is nearest to another point.
#[derive(Clone, Copy, Debug)]
pub struct Near {
    /// Its triangle, and its weights at the corners.
    pub triangle: u32,
    pub weights: V3<f64>,
    /// The point \[m\].
    pub at: V3<f64>,
    /// The direction in which the height grows.
    pub normal: V3<f64>,
    /// The distance of the other point \[m\], below 0 inside.
    pub height: f64,
    /// Whether the other point is beside a border, with no surface below it.
    pub is_beside: bool,
}

impl<'a> Posed<'a> {
    /// The surface at rest. O(n).
    pub fn at_rest(surface: &'a BodySurface) -> Self {
        Posed::put(surface, surface.rest.iter().map(|p| cast(*p)).collect())
    }

    /// The surface where joints put it, of which there is a matrix each; at rest if it follows none. O(n).
    pub fn by_joints(surface: &'a BodySurface, skinning: Skinning, matrices: &[Rows]) -> Self {
        if surface.sets == 0 || matrices.len() < surface.joints() {
            return Posed::at_rest(surface);
        }
        let poses = Poses::new(skinning, matrices);
        let own = surface.influences.chunks(surface.sets);
        Posed::put(surface, surface.rest.iter().zip(own).map(|(p, own)| poses.place(own, cast(*p))).collect())
    }

    /// The surface with its vertices at these positions \[m\]. O(n).
    pub fn put(surface: &'a BodySurface, at: Vec<V3<f64>>) -> Self {
        let normals = vertex_normals(&surface.triangles, &at);
        let mut bounds = Vec::new();
        surface.tree.fit(|t| surface.triangles[t as usize].map(|v| at[v as usize]), &mut bounds);
        Posed { surface, at, normals, bounds }
    }

    /// The height \[m\] of a point above it, below 0 inside. O(log n).
    pub fn height(&self, p: V3<f64>) -> f64 {
        self.near(p).height
    }

    /// The point of it that is nearest to `p`. O(log n).
    pub fn near(&self, p: V3<f64>) -> Near {
        let triangle = |t: u32| self.surface.triangles[t as usize];
        let corners = |t: u32| triangle(t).map(|v| self.at[v as usize]);
        let (t, _) = self.surface.tree.nearest(&self.bounds, p, |t| on_triangle(p, t, corners(t)).distance2);
        let (own, spot) = (corners(t), on_triangle(p, t, corners(t)));
        let mix = |list: [V3<f64>; 3]| (0..3).fold([0.0; 3], |sum, k| add(sum, scale(list[k], spot.weights[k])));
        // Those of [`vertex_normals`], by which inside is exact.
        let up = match spot.on {
            On::Face => normal(own),
            On::Side(side) => {
                let other = self.surface.across[t as usize][usize::from(side)];
                let both = [t, if other == NONE { t } else { other }].map(|t| unit(normal(corners(t))));
                add(both[0], both[1])
            }
            On::Corner(corner) => self.normals[triangle(t)[usize::from(corner)] as usize],
        };
        let up = unit(up);
        let (at, far) = (mix(own), spot.distance2.sqrt());
        let from = sub(p, at);
        let rise = dot(from, up);
        let height = if rise < 0.0 { -far } else { far };
        let normal = if far > ON_SURFACE_M { scale(from, 1.0 / height) } else { up };
        let is_beside = self.surface.is_border(&spot) && rise.abs() < BESIDE_COSINE * far;
        Near { triangle: t, weights: spot.weights, at, normal, height, is_beside }
    }

    /// The first point at which a line from `p` along the unit vector `way` leaves the surface through a triangle that faces along it, no farther \[m\] than
    /// `reach`: its distance, and the normal there. O(log n).
    pub fn exit(&self, p: V3<f64>, way: V3<f64>, reach: f64) -> Option<(f64, V3<f64>)> {
        let mut best: Option<(f64, u32)> = None;
        let corners = |t: u32| self.surface.triangles[t as usize].map(|v| self.at[v as usize]);
        let end = add(p, scale(way, reach));
        let meets =
            |[low, high]: &[V3<f64>; 2]| (0..3).all(|c| p[c].min(end[c]) <= high[c] && p[c].max(end[c]) >= low[c]);
        self.surface.tree.visit(&self.bounds, meets, |t| {
            let [a, b, c] = corners(t);
            // T. Moeller and B. Trumbore, "Fast, Minimum Storage Ray/Triangle Intersection", 1997; from behind.
            let (u, v) = (sub(b, a), sub(c, a));
            let h = cross(way, v);
            let det = dot(u, h);
            if det >= 0.0 {
                return;
            }
            let s = sub(p, a);
            let q = cross(s, u);
            let (x, y, far) = (dot(s, h) / det, dot(way, q) / det, dot(v, q) / det);
            let is_first = best.is_none_or(|(least, other)| far < least || (far == least && t < other));
            if x >= 0.0 && y >= 0.0 && x + y <= 1.0 && (0.0..=reach).contains(&far) && is_first {
                best = Some((far, t));
            }
        });
        best.map(|(far, t)| (far, unit(normal(corners(t)))))
    }

    /// How often it winds around points: 1 inside, 0 outside. O(n log n) to make, and about O(log n) per point.
    pub fn winding(&self) -> Winding {
        Winding::new(self.surface.triangles.iter().map(|t| t.map(|v| self.at[v as usize])))
    }
}

/// A vector at length 1; 0 where it has none.
fn unit(v: V3<f64>) -> V3<f64> {
    scale(v, 1.0 / dot(v, v).sqrt().max(f64::MIN_POSITIVE))
}

/// The heights \[m\] of points above a surface at rest, below 0 inside. O(log n) per point.
pub fn heights(surface: &BodySurface, points: impl Iterator<Item = [f32; 3]>) -> Vec<f32> {
    let posed = Posed::at_rest(surface);
    points.map(|p| posed.height(cast(p)) as f32).collect()
}
