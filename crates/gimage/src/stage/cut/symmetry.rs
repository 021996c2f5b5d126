//! The mirror plane of a surface that is the same on its left and its right.
//!
//! The plane of a mirror image lies through the centre of the area, square to an axis of its covariance; the three of
//! them are tried. Garments are never quite symmetric (buttons, folds, a hand-made mesh), so near enough counts.

use nalgebra::{Matrix3, SymmetricEigen, Vector3};

use crate::base::closest::Closest;
use crate::base::surface::Surface;
use crate::base::vec3::{add, cross, dot, norm, scale, sub};

/// Largest RMS distance between a symmetric surface and its mirror image, as a share of its size.
const NEAR: f64 = 0.025;

/// A mirror plane.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(crate) struct Mirror {
    /// A point of it \[m\].
    pub point: [f64; 3],
    /// Its unit normal.
    pub normal: [f64; 3],
}

impl Mirror {
    /// The plane in which a surface is nearest to its own mirror image, if that is near enough. O(n log n).
    pub(crate) fn of(surface: &Surface) -> Option<Self> {
        let corners = |t: usize| surface.corners(t);
        let (mut area, mut centre) = (0.0, [0.0; 3]);
        let weigh = |t: usize| {
            let [a, b, c] = corners(t);
            (norm(cross(sub(b, a), sub(c, a))), scale(add(add(a, b), c), 1.0 / 3.0))
        };
        for (w, m) in (0..surface.triangles.len()).map(weigh) {
            area += w;
            centre = add(centre, scale(m, w));
        }
        centre = scale(centre, 1.0 / area.max(1e-300));
        let mut spread = Matrix3::zeros();
        for (w, m) in (0..surface.triangles.len()).map(weigh) {
            let d = Vector3::from(sub(m, centre));
            spread += w * d * d.transpose();
        }
        let size = (spread.trace() / area.max(1e-300)).sqrt();
        if !(size.is_finite() && size > 0.0) {
            return None;
        }
        let eigen = SymmetricEigen::new(spread);
        let closest = Closest::new(&surface.positions, &surface.triangles);
        let mut best: Option<(f64, Self)> = None;
        for (axis, &wide) in eigen.eigenvectors.column_iter().zip(&eigen.eigenvalues) {
            // A flat surface is its own mirror image in its own plane, and has no two sides.
            if wide < 1e-6 * spread.trace() {
                continue;
            }
            let mirror = Self { point: centre, normal: [axis[0], axis[1], axis[2]] };
            let off = |p: &[f64; 3]| closest.project(mirror.reflect(*p)).map_or(f64::INFINITY, |n| n.distance.powi(2));
            let square = surface.positions.iter().map(off).sum::<f64>() / surface.positions.len() as f64;
            if square.sqrt() < NEAR * size && best.is_none_or(|b| square < b.0) {
                best = Some((square, mirror));
            }
        }
        best.map(|b| b.1)
    }

    /// How far in front of the plane a point is \[m\].
    pub(crate) fn offset(&self, p: [f64; 3]) -> f64 {
        dot(sub(p, self.point), self.normal)
    }

    /// The mirror image of a point.
    pub(crate) fn reflect(&self, p: [f64; 3]) -> [f64; 3] {
        sub(p, scale(self.normal, 2.0 * self.offset(p)))
    }

    /// For each point the one nearest to its mirror image. O(n^2).
    pub(crate) fn mates(&self, points: &[[f64; 3]]) -> Vec<u32> {
        points
            .iter()
            .map(|&p| {
                let q = self.reflect(p);
                let gap = |k: usize| {
                    let d = sub(points[k], q);
                    dot(d, d)
                };
                (0..points.len()).min_by(|&a, &b| gap(a).total_cmp(&gap(b)).then(a.cmp(&b))).unwrap_or(0) as u32
            })
            .collect()
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::base::shapes;

    /// A sheet bent the same way on both sides of x = 0.5, turned and moved.
    fn vest(skew: f64) -> Surface {
        let mut s = shapes::sheet(24, 18, shapes::Join::Open, shapes::Join::Open, |u, v| {
            let x = u - 0.5;
            [x, 1.7 * v + 0.4 * x * x + skew * x * x * x, 0.3 * (9.0 * x * x + v).sin()]
        });
        let (sin, cos) = 0.7f64.sin_cos();
        s.positions.iter_mut().for_each(|p| *p = [cos * p[0] - sin * p[1] + 4.0, sin * p[0] + cos * p[1], p[2] - 2.0]);
        s
    }

    #[test]
    fn the_plane_of_a_symmetric_surface_is_found_wherever_it_stands() {
        let s = vest(0.0);
        let m = Mirror::of(&s).unwrap();
        let (sin, cos) = 0.7f64.sin_cos();
        assert!((dot(m.normal, [cos, sin, 0.0]).abs() - 1.0).abs() < 1e-6, "{m:?}");
        assert!(m.offset([4.0, 0.0, -2.0]).abs() < 1e-3, "{m:?}");
        let mates = m.mates(&s.positions);
        assert!((0..s.positions.len()).all(|v| mates[mates[v] as usize] as usize == v));
        assert_eq!((0..mates.len()).filter(|&v| mates[v] as usize == v).count(), 19, "the middle column is its own");
    }

    #[test]
    fn the_plane_of_a_flat_sheet_does_not_count() {
        let m = Mirror::of(&shapes::rectangle(6, 4, 3.0, 2.0)).unwrap();
        assert!(m.normal[2].abs() < 1e-9, "{m:?}");
    }

    #[test]
    fn what_is_not_symmetric_has_no_plane() {
        assert_eq!(Mirror::of(&vest(3.0)), None);
    }
}
