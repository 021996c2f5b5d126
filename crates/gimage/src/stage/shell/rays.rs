//! Finds with a few rays per component whether a second sheet faces it at a small distance, and estimates that distance.

use std::collections::BTreeMap;

use crate::base::closest::Closest;
use crate::base::mesh::Mesh;
use crate::base::vec3::{add, cross, dot, norm, normalize, scale, sub};
use crate::stage::component::Component;

/// Rays that start at a component, at equal steps of its area.
const RAYS: f64 = 256.0;
/// Thickness over the side of a square with half the area of a component, below which the component is thin.
pub(super) const THIN: f64 = 0.05;
/// Share of the area that must have an opposite sheet; the rest is rims.
pub(super) const FACING: f64 = 0.7;
/// Cosine between the normals of two sheets below which they face each other.
const OPPOSITE: f64 = -0.5;

/// An opposite sheet of a component.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(crate) struct Opposite {
    /// Median distance \[m\].
    pub thickness: f64,
    /// The component that most of the sheet belongs to.
    pub component: u32,
    /// Share of the area that has one.
    pub share: f64,
    /// The side that it lies on: 1 where the normals point, -1 behind them.
    pub side: f64,
}

/// The end of a ray.
struct Hit {
    /// Its length \[m\].
    gap: f64,
    /// The share of the component's area that it stands for.
    weight: f64,
    /// The component that it meets.
    component: u32,
}

/// A mesh prepared for rays.
pub(crate) struct Sheets<'a> {
    mesh: &'a Mesh,
    tree: Closest,
    /// For each triangle its component.
    owner: &'a [u32],
}

impl<'a> Sheets<'a> {
    /// `owner` has the component of each triangle. O(n log n).
    pub fn new(mesh: &'a Mesh, owner: &'a [u32]) -> Self {
        Self { mesh, tree: Closest::new(&mesh.positions, &mesh.triangles), owner }
    }

    /// The sheet that faces most of a component on one of its sides: of the component itself, or of another.
    pub fn opposite(&self, component: &Component) -> Option<Opposite> {
        self.nearest(component).filter(|o| o.share >= FACING)
    }

    /// The sheet that faces the largest share of a component; `None` if none faces it. The work is that of some [`RAYS`] rays,
    /// whatever the number of triangles.
    pub fn nearest(&self, component: &Component) -> Option<Opposite> {
        let reach = reach(component.area);
        let starts = self.starts(component);
        let total: f64 = starts.iter().map(|s| s.1).sum();
        let side = |side: f64| {
            let mut hits: Vec<Hit> = Vec::new();
            for &(t, weight) in &starts {
                let points = subcentres(&self.mesh.corners(t as usize), weight);
                let weight = weight / points.len() as f64;
                let found = points.iter().filter_map(|&p| self.hit(t, p, side, reach));
                hits.extend(found.map(|(gap, t)| Hit { gap, weight, component: self.owner[t as usize] }));
            }
            hits.sort_by(|a, b| a.gap.total_cmp(&b.gap).then(a.component.cmp(&b.component)));
            let share = hits.iter().map(|h| h.weight).sum::<f64>() / total;
            let thickness = median(&hits.iter().map(|h| (h.gap, h.weight)).collect::<Vec<_>>())?;
            Some(Opposite { thickness, component: most(&hits)?, share, side })
        };
        // Inside first: the normals of a closed component point out of it.
        [side(-1.0), side(1.0)].into_iter().flatten().reduce(|a, b| if b.share > a.share { b } else { a })
    }

    /// Triangles at equal steps of area, with the number of steps that each stands for.
    fn starts(&self, component: &Component) -> Vec<(u32, f64)> {
        let step = component.area / RAYS;
        let (mut sum, mut next) = (0.0, 0.5 * step);
        let mut starts = Vec::new();
        for &t in &component.triangles {
            sum += self.mesh.triangle_area(t as usize);
            if sum > next {
                let steps = ((sum - next) / step).floor().max(0.0) + 1.0;
                starts.push((t, steps));
                next += step * steps;
            }
        }
        starts
    }

    /// Distance \[m\], at most `reach`, from a point of triangle `t` to the first triangle that faces it on a side of it, and that
    /// triangle.
    pub fn hit(&self, t: u32, from: [f64; 3], side: f64, reach: f64) -> Option<(f64, u32)> {
        let [a, b, c] = self.mesh.corners(t as usize);
        let normal = cross(sub(b, a), sub(c, a));
        if norm(normal) == 0.0 {
            return None;
        }
        let normal = normalize(normal);
        let is_hit = |other: u32, n: [f64; 3]| other != t && dot(n, normal) < OPPOSITE;
        self.tree.along(from, scale(normal, side), reach, is_hit)
    }
}

/// Largest distance \[m\] of the opposite sheet of a component of an area \[m2\].
pub(super) fn reach(area: f64) -> f64 {
    THIN * (0.5 * area).sqrt()
}

/// The component with the largest weight among hits; the first of equals.
fn most(hits: &[Hit]) -> Option<u32> {
    let mut weights: BTreeMap<u32, f64> = BTreeMap::new();
    hits.iter().for_each(|h| *weights.entry(h.component).or_default() += h.weight);
    weights.into_iter().reduce(|a, b| if b.1 > a.1 { b } else { a }).map(|x| x.0)
}

/// The value that half of the weight lies below, of ascending values.
pub(super) fn median(sorted: &[(f64, f64)]) -> Option<f64> {
    quantile(sorted, 0.5)
}

/// The value that a share of the weight lies below, of ascending (value, weight).
pub(super) fn quantile(sorted: &[(f64, f64)], share: f64) -> Option<f64> {
    let total: f64 = sorted.iter().map(|x| x.1).sum();
    let mut sum = 0.0;
    let found = sorted.iter().find(|x| {
        sum += x.1;
        sum >= share * total
    });
    found.or(sorted.last()).map(|x| x.0)
}

/// Points spread evenly over a triangle: the centres of 1, 4 or 16 equal parts of it, as many as it stands for.
pub(super) fn subcentres(corners: &[[f64; 3]; 3], wanted: f64) -> Vec<[f64; 3]> {
    let n = if wanted <= 2.0 {
        1
    } else if wanted <= 8.0 {
        2
    } else {
        4
    };
    let [a, b, c] = *corners;
    let at = |i: f64, j: f64| {
        let (v, w) = (i / f64::from(n), j / f64::from(n));
        add(scale(a, 1.0 - v - w), add(scale(b, v), scale(c, w)))
    };
    let third = 1.0 / 3.0;
    let mut out = Vec::new();
    for i in 0..n {
        for j in 0..n - i {
            let (x, y) = (f64::from(i), f64::from(j));
            out.push(at(x + third, y + third));
            if i + j + 1 < n {
                out.push(at(x + 2.0 * third, y + 2.0 * third));
            }
        }
    }
    out
}
