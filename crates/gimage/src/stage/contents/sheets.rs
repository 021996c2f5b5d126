//! Finds sheets that face each other at a small distance, and estimates that distance.

use crate::base::closest::Closest;
use crate::base::mesh::Mesh;
use crate::base::vec3::{add, cross, dot, norm, normalize, scale, sub};
use crate::stage::component::Component;

/// Triangles of a component that a ray starts from, at most.
const MAX_RAYS: usize = 256;
/// Thickness over the side of a square with half the area of a component, below which the component is thin.
const THIN: f64 = 0.05;
/// Share of rays that must meet an opposite sheet; the rest starts at rims.
const FACING: f64 = 0.7;
/// Cosine between the normals of two sheets below which they face each other.
const OPPOSITE: f64 = -0.5;

/// An opposite sheet of a component.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(super) struct Opposite {
    /// Median distance \[m\].
    pub thickness: f64,
    /// The component that the sheet belongs to.
    pub component: u32,
}

/// A mesh prepared for rays.
pub(super) struct Sheets<'a> {
    mesh: &'a Mesh,
    tree: Closest,
    /// For each triangle its component.
    owner: &'a [u32],
}

impl<'a> Sheets<'a> {
    pub fn new(mesh: &'a Mesh, owner: &'a [u32]) -> Self {
        Self { mesh, tree: Closest::new(&mesh.positions, &mesh.triangles), owner }
    }

    /// The sheet that faces most of a component on one of its sides: of the component itself, or of another. Rays start at
    /// up to [`MAX_RAYS`] triangles, at equal steps of area, so that the result is deterministic. O(rays x log triangles).
    pub fn opposite(&self, component: &Component) -> Option<Opposite> {
        let reach = THIN * (0.5 * component.area).sqrt();
        let starts = self.starts(component);
        let side = |sign: f64| {
            let mut hits: Vec<(f64, u32)> = starts.iter().filter_map(|&t| self.hit(t, sign, reach)).collect();
            if (hits.len() as f64) < FACING * starts.len() as f64 || hits.is_empty() {
                return None;
            }
            hits.sort_by(|a, b| a.0.total_cmp(&b.0).then(a.1.cmp(&b.1)));
            let thickness = hits[hits.len() / 2].0;
            let mut owners: Vec<u32> = hits.iter().map(|h| h.1).collect();
            owners.sort_unstable();
            let most = owners.chunk_by(|a, b| a == b).max_by_key(|run| run.len())?;
            Some(Opposite { thickness, component: most[0] })
        };
        // Inside first: the normals of a closed component point out of it.
        [side(-1.0), side(1.0)].into_iter().flatten().min_by(|a, b| a.thickness.total_cmp(&b.thickness))
    }

    fn starts(&self, component: &Component) -> Vec<u32> {
        let step = component.area / MAX_RAYS as f64;
        let (mut sum, mut next) = (0.0, 0.5 * step);
        let mut starts = Vec::new();
        for &t in &component.triangles {
            sum += self.mesh.triangle_area(t as usize);
            if sum > next {
                starts.push(t);
                // A large triangle stands for all steps that end in it.
                next += step * ((sum - next) / step).floor().max(0.0) + step;
            }
        }
        starts
    }

    /// The first triangle within reach of triangle `t` that faces it, on the side of its normal (`sign` 1) or behind it.
    fn hit(&self, t: u32, sign: f64, reach: f64) -> Option<(f64, u32)> {
        let [a, b, c] = self.mesh.corners(t as usize);
        let normal = cross(sub(b, a), sub(c, a));
        if norm(normal) == 0.0 {
            return None;
        }
        let normal = normalize(normal);
        let middle = scale(add(add(a, b), c), 1.0 / 3.0);
        let is_hit = |other: u32, n: [f64; 3]| other != t && dot(n, normal) < OPPOSITE;
        let (distance, other) = self.tree.along(middle, scale(normal, sign), reach, is_hit)?;
        Some((distance, self.owner[other as usize]))
    }
}
