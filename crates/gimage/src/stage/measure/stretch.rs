//! Distortion measured on the image: from the texel lattice to its triangles.
//!
//! Geometric stretch is that of Sander, Snyder, Gortler and Hoppe, "Texture Mapping Progressive Meshes", 2001, scaled so
//! that an isometry up to size has 1; symmetric Dirichlet energy is taken at the size that makes it least, so that an
//! isometry up to size has 4.

use crate::base::grid::Grid;
use crate::base::order::percentile;
use crate::base::vec3::{add, cross, dot, norm, sub};
use crate::stage::assemble::springs::{DOWN, RIGHT, RestLengths};
use serde::Serialize;

/// How evenly the texels cover the surface.
#[derive(Clone, Copy, Debug, PartialEq, Serialize)]
pub struct GridStretch {
    /// Root mean square stretch, 1 or more.
    pub l2: f64,
    /// Largest stretch.
    pub linf: f64,
    /// Mean symmetric Dirichlet energy, 4 or more.
    pub symmetric_dirichlet: f64,
    /// Triangles smaller than 1e-9 of the mean.
    pub degenerate_triangles: usize,
    /// Triangles of the grid.
    pub triangles: usize,
}

/// Stretch from the texel lattice to the stored positions, weighted by area; `None` without a triangle of some area.
pub fn grid_stretch(grid: &Grid) -> Option<GridStretch> {
    let triangles = grid.triangulate();
    let w = grid.width;
    // The two derivatives of each triangle: one of its sides runs along a row, another along a column.
    let tangents = |t: &[u32; 3]| {
        let (mut s, mut d) = ([0.0; 3], [0.0; 3]);
        for c in 0..3 {
            let (a, b) = (t[c] as usize, t[(c + 1) % 3] as usize);
            let (from, to) = (a.min(b) as u32, a.max(b) as u32);
            let side = sub(grid.stored(to), grid.stored(from));
            if a / w == b / w {
                s = side;
            } else if a % w == b % w {
                d = side;
            }
        }
        (s, d)
    };
    let area2: Vec<f64> = triangles.iter().map(&tangents).map(|(s, d)| norm(cross(s, d))).collect();
    let total: f64 = area2.iter().sum();
    if !(total > 0.0 && total.is_finite()) {
        return None;
    }
    let kept: Vec<usize> = (0..triangles.len()).filter(|&t| area2[t] > 1e-14 * total).collect();
    let kept_area: f64 = kept.iter().map(|&t| area2[t]).sum();
    // Each triangle of the lattice has twice the area 1.
    let unit2 = triangles.len() as f64 / total;
    let (mut l2, mut linf, mut inverse) = (0.0, 0.0f64, 0.0);
    for &t in &kept {
        let (s, d) = tangents(&triangles[t]);
        let (e, f, g) = (dot(s, s), dot(s, d), dot(d, d));
        let root = ((e - g) * (e - g) + 4.0 * f * f).sqrt();
        let (large, small) = (unit2 * 0.5 * (e + g + root), unit2 * (0.5 * (e + g - root)).max(1e-300));
        let weight = area2[t] / kept_area;
        l2 += weight * (large + small);
        inverse += weight * (1.0 / large + 1.0 / small);
        linf = linf.max(large);
    }
    let mean = total / triangles.len() as f64;
    Some(GridStretch {
        l2: (0.5 * l2).sqrt(),
        linf: linf.sqrt(),
        symmetric_dirichlet: 2.0 * (l2 * inverse).sqrt(),
        degenerate_triangles: area2.iter().filter(|&&a| a < 1e-9 * mean).count(),
        triangles: triangles.len(),
    })
}

/// How far the structural springs are from a lattice of squares.
#[derive(Clone, Copy, Debug, PartialEq, Serialize)]
pub struct Anisotropy {
    /// Longest structural rest length / shortest.
    pub longest_to_shortest: f64,
    /// The same of the 99th percentile and the 1st.
    pub p99_to_p1: f64,
    /// Mean deviation from a right angle between the right and down directions, weighted by area \[degrees\].
    pub angle_deviation: f64,
}

/// Anisotropy of the springs of an image; `None` without structural springs.
pub fn spring_anisotropy(grid: &Grid, rest: &RestLengths) -> Option<Anisotropy> {
    if !grid.is_sized() {
        return None;
    }
    let (w, h) = (grid.width, grid.height);
    let mut lengths = Vec::with_capacity(2 * w * h);
    for k in 0..w * h {
        let r = rest.at(k);
        lengths.extend((k % w + 1 < w).then_some(r[RIGHT]));
        lengths.extend((k / w + 1 < h).then_some(r[DOWN]));
    }
    lengths.retain(|&l| l > 0.0 && l.is_finite());
    let [shortest, low, high, longest] = [0.0, 0.01, 0.99, 1.0].map(|p| percentile(&mut lengths, p));
    let (mut sum, mut weight) = (0.0, 0.0);
    for j in 1..h {
        for i in 1..w {
            let [a, b, c, d] = [(i - 1, j - 1), (i, j - 1), (i, j), (i - 1, j)].map(|(i, j)| {
                let k = j * w + i;
                grid.stored(k as u32)
            });
            // The derivatives at the middle of the quad.
            let (right, down) = (add(sub(b, a), sub(c, d)), add(sub(d, a), sub(c, b)));
            let (area, along) = (norm(cross(right, down)), dot(right, down));
            if area > 0.0 && area.is_finite() {
                sum += area * (along.abs() / area).atan().to_degrees();
                weight += area;
            }
        }
    }
    Some(Anisotropy {
        longest_to_shortest: longest? / shortest?,
        p99_to_p1: high? / low?,
        angle_deviation: if weight > 0.0 { sum / weight } else { 0.0 },
    })
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::base::grid::samples::{grid, torus};
    use crate::stage::assemble::springs::{Rest, springs};

    #[test]
    fn a_lattice_of_squares_is_perfect() {
        let g = grid(9, 5, |u, v| [0.8 * u, 3.0, 0.4 * v]);
        let s = grid_stretch(&g).unwrap();
        assert!((s.l2 - 1.0).abs() < 1e-6 && (s.linf - 1.0).abs() < 1e-5 && (s.symmetric_dirichlet - 4.0).abs() < 1e-6);
        let a = spring_anisotropy(&g, &springs(&g, Rest::Chord)).unwrap();
        assert!((a.longest_to_shortest - 1.0).abs() < 1e-5 && a.angle_deviation < 1e-4);
    }

    /// Texels twice as wide as high: singular values sqrt(2) and 1/sqrt(2) at equal area.
    #[test]
    fn a_lattice_of_rectangles_has_known_stretch() {
        let g = grid(5, 5, |u, v| [2.0 * u, v, 0.0]);
        let s = grid_stretch(&g).unwrap();
        assert!((s.l2 - 1.25f64.sqrt()).abs() < 1e-6 && (s.linf - 2f64.sqrt()).abs() < 1e-6);
        assert!((s.symmetric_dirichlet - 5.0).abs() < 1e-5);
        let a = spring_anisotropy(&g, &springs(&g, Rest::Chord)).unwrap();
        assert!((a.longest_to_shortest - 2.0).abs() < 1e-6 && (a.p99_to_p1 - 2.0).abs() < 1e-6);
    }

    #[test]
    fn a_sheared_lattice_deviates_by_its_angle() {
        let g = grid(5, 5, |u, v| [u + 0.5 * v, v, 0.0]);
        let a = spring_anisotropy(&g, &springs(&g, Rest::Chord)).unwrap();
        assert!((a.angle_deviation - 0.5f64.atan().to_degrees()).abs() < 1e-4);
    }

    #[test]
    fn nothing_measures_nothing() {
        assert!(grid_stretch(&Grid::default()).is_none());
        assert!(grid_stretch(&grid(3, 3, |_, _| [1.0; 3])).is_none());
        assert!(spring_anisotropy(&grid(3, 3, |_, _| [1.0; 3]), &RestLengths::Constant([0.0; 4])).is_none());
        assert!(grid_stretch(&torus(17, 9)).unwrap().l2 >= 1.0);
    }
}
