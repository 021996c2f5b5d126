//! The body that garments rest on.

use gimage_bundle::Winding;
use rayon::prelude::*;

use super::ends::{self, End};
use crate::base::closest::Closest;
use crate::base::mesh::Mesh;
use crate::base::vec3::{add, cross, distance, dot, normalize, scale, sub};
use crate::stage::import::bones;

/// Winding number from which a point is inside.
const INSIDE: f64 = 0.5;

/// A body, ready for queries: its surface, and the bones of its skeleton, which stand for parts of the body that a file left out beneath
/// clothes.
pub struct Wearer {
    closest: Closest,
    winding: Winding,
    /// How far each triangle faces up, -1 to 1.
    up: Vec<f64>,
    /// From each joint to its parent \[m\], as the mesh is bound.
    bones: Vec<[[f64; 3]; 2]>,
    /// Where it ends.
    pub(super) ends: Vec<End>,
    /// Lowest and highest point \[m\].
    pub(super) span: [f64; 2],
}

impl Wearer {
    /// From the triangles and the skeleton of a body; `None` without a triangle. Y is up.
    pub fn new(body: &Mesh) -> Option<Self> {
        let (low, high) = body.bounds()?;
        let closest = Closest::new(&body.positions, &body.triangles);
        if closest.is_empty() {
            return None;
        }
        let up = |t: usize| {
            let [a, b, c] = body.corners(t);
            normalize(cross(sub(b, a), sub(c, a)))[1]
        };
        Some(Wearer {
            winding: Winding::new((0..body.triangles.len()).map(|t| body.corners(t))),
            up: (0..body.triangles.len()).map(up).collect(),
            bones: bones(&body.skeleton).into_iter().map(|bone| bone.ends).collect(),
            ends: ends::of(body),
            span: [low[1], high[1]],
            closest,
        })
    }

    /// Distance \[m\] of a point from the body, and how far the body faces up there, -1 to 1.
    pub(super) fn near(&self, p: [f64; 3]) -> (f64, f64) {
        self.closest.project(p).map_or((f64::INFINITY, 0.0), |n| (n.distance, self.up[n.triangle as usize]))
    }

    /// For each point how deep \[m\] it is inside of the body, 0 outside. About O(log triangles) per point.
    pub(super) fn depths(&self, points: &[[f64; 3]]) -> Vec<f64> {
        let depth = |p: &[f64; 3]| if self.winding.number(*p) > INSIDE { self.near(*p).0 } else { 0.0 };
        points.par_iter().map(depth).collect()
    }

    /// Distance \[m\] of a point from the nearest bone, infinite without one. With `below`, only of points of bones that are lower.
    pub(super) fn to_bone(&self, p: [f64; 3], below: bool) -> f64 {
        let far = |[a, b]: &[[f64; 3]; 2]| {
            let along = sub(*b, *a);
            let t = (dot(sub(p, *a), along) / dot(along, along).max(1e-300)).clamp(0.0, 1.0);
            let q = add(*a, scale(along, t));
            if below && q[1] > p[1] { f64::INFINITY } else { distance(p, q) }
        };
        self.bones.iter().map(far).fold(f64::INFINITY, f64::min)
    }
}
