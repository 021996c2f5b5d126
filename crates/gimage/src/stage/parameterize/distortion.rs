//! The distortion of a map from a surface to the plane: symmetric Dirichlet energy, L2 stretch, flips.
//!
//! The Jacobian of the map on a triangle is `J = sum_k p_k g_k^T` with `p_k` the planar corners and `g_k` the gradients
//! of the corner functions in the triangle's own plane. Its singular values are those of surface -> plane.

use rayon::prelude::*;

use crate::base::vec3::{cross, dot, norm, sub};

/// Triangles per parallel chunk: fixed, so that sums do not depend on the number of threads.
pub(crate) const CHUNK: usize = 2048;

/// One triangle at rest.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Rest {
    /// Gradients of the three corner functions, scaled so that an isometry up to the map's mean scale has J = I.
    pub g: [[f64; 2]; 3],
    /// Share of the whole area.
    pub weight: f64,
}

/// Rest shapes of all triangles. `scale` is the length in the plane of a unit length on the surface, usually
/// sqrt(planar area / surface area); `wanted` is one number a vertex that multiplies it.
///
/// Slivers and specks are fattened (height at least 1e-3 of the base, weight at least 1e-4 of the mean), or a single bad
/// triangle could stop the solver for all the others.
pub(crate) fn rest_shapes(positions: &[[f64; 3]], triangles: &[[u32; 3]], wanted: &[f64], scale: f64) -> Vec<Rest> {
    let total: f64 = triangles.iter().map(|&t| rest_area(positions, t, wanted)).sum();
    let floor = 1e-4 / triangles.len().max(1) as f64;
    triangles
        .par_iter()
        .with_min_len(CHUNK)
        .map(|&t| {
            let mut rest = rest_shape(positions, t, wanted, scale);
            rest.weight = (rest.weight / total.max(1e-300)).max(floor);
            rest
        })
        .collect()
}

/// All triangles at rest, to be used for maps of several sizes.
pub(crate) struct RestShapes {
    pub shapes: Vec<Rest>,
    /// Areas of the triangles with their lengths as wanted, and their sum.
    pub areas: Vec<f64>,
    pub area: f64,
    scale: f64,
}

impl RestShapes {
    pub(crate) fn new(positions: &[[f64; 3]], triangles: &[[u32; 3]], wanted: &[f64]) -> Self {
        let areas: Vec<f64> = triangles.iter().map(|&t| rest_area(positions, t, wanted)).collect();
        let area = areas.iter().sum();
        Self { shapes: rest_shapes(positions, triangles, wanted, 1.0), areas, area, scale: 1.0 }
    }

    /// Sets the length in the plane of a unit length on the surface.
    pub(crate) fn set_scale(&mut self, scale: f64) {
        let by = self.scale / scale;
        if by != 1.0 {
            self.shapes.iter_mut().flat_map(|r| r.g.as_flattened_mut()).for_each(|g| *g *= by);
        }
        self.scale = scale;
    }
}

/// The area of a triangle with its lengths as `wanted`.
pub(crate) fn rest_area(positions: &[[f64; 3]], t: [u32; 3], wanted: &[f64]) -> f64 {
    let [a, b, c] = t.map(|v| positions[v as usize]);
    0.5 * mean(wanted, t).powi(2) * norm(cross(sub(b, a), sub(c, a)))
}

/// One of [`rest_shapes`], with its area as weight.
pub(crate) fn rest_shape(positions: &[[f64; 3]], t: [u32; 3], wanted: &[f64], scale: f64) -> Rest {
    let (m, area) = (mean(wanted, t), rest_area(positions, t, wanted));
    let p = t.map(|v| crate::base::vec3::scale(positions[v as usize], m));
    // The longest edge is the base: the height is then the best conditioned.
    let l = [0, 1, 2].map(|k| norm(sub(p[(k + 1) % 3], p[k])));
    let k = (0..3).fold(0, |m, k| if l[k] > l[m] { k } else { m });
    let (a, b, c) = (p[k], p[(k + 1) % 3], p[(k + 2) % 3]);
    let x = l[k].max(1e-300);
    let u = sub(b, a);
    let foot = dot(sub(c, a), u) / x;
    let height = (2.0 * area / x).max(1e-3 * x);
    let s = 1.0 / scale;
    let (i00, i01, i11) = (s / x, -s * foot / (x * height), s / height);
    let mut g = [[0.0; 2]; 3];
    g[k] = [-i00, -i01 - i11];
    g[(k + 1) % 3] = [i00, i01];
    g[(k + 2) % 3] = [0.0, i11];
    Rest { g, weight: area }
}

/// The mean of a triangle's corners.
#[inline]
pub(crate) fn mean(of: &[f64], t: [u32; 3]) -> f64 {
    t.iter().map(|&v| of[v as usize]).sum::<f64>() / 3.0
}

/// The Jacobian, row-major, of the map that takes the corners of a triangle to `p`.
#[inline]
pub(crate) fn jacobian(rest: &Rest, p: [[f64; 2]; 3]) -> [f64; 4] {
    let mut j = [0.0; 4];
    for (p, g) in p.iter().zip(&rest.g) {
        j[0] += p[0] * g[0];
        j[1] += p[0] * g[1];
        j[2] += p[1] * g[0];
        j[3] += p[1] * g[1];
    }
    j
}

/// Symmetric Dirichlet density |J|^2 + |J^-1|^2 (4 for an isometry), infinite for a flipped triangle.
#[inline]
pub(crate) fn density(j: [f64; 4]) -> f64 {
    let det = j[0] * j[3] - j[1] * j[2];
    if det > 0.0 { j.iter().map(|x| x * x).sum::<f64>() * (1.0 + 1.0 / (det * det)) } else { f64::INFINITY }
}

/// Twice the signed area of a planar triangle.
#[inline]
pub(crate) fn signed_area2(p: [[f64; 2]; 3]) -> f64 {
    (p[1][0] - p[0][0]) * (p[2][1] - p[0][1]) - (p[2][0] - p[0][0]) * (p[1][1] - p[0][1])
}

/// The planar corners of a triangle.
#[inline]
pub(crate) fn planar(uv: &[[f64; 2]], t: [u32; 3]) -> [[f64; 2]; 3] {
    t.map(|v| uv[v as usize])
}

/// Area-weighted mean of the symmetric Dirichlet density; infinite if any triangle is flipped.
pub(crate) fn energy(rest: &[Rest], triangles: &[[u32; 3]], uv: &[[f64; 2]]) -> f64 {
    let chunks: Vec<f64> = rest
        .par_chunks(CHUNK)
        .zip(triangles.par_chunks(CHUNK))
        .map(|(r, t)| r.iter().zip(t).map(|(r, &t)| r.weight * density(jacobian(r, planar(uv, t)))).sum())
        .collect();
    let sum: f64 = chunks.iter().sum();
    if sum.is_nan() { f64::INFINITY } else { sum }
}

/// Area-weighted mean of ln(density / 4): 0 for an isometry. Unlike the mean itself it is not ruled by the few worst
/// triangles, so it ranks maps that are far from their minimum.
pub(crate) fn log_distortion(rest: &[Rest], triangles: &[[u32; 3]], uv: &[[f64; 2]]) -> f64 {
    let (mut sum, mut weight) = (0.0, 0.0);
    for (r, &t) in rest.iter().zip(triangles) {
        sum += r.weight * (density(jacobian(r, planar(uv, t))) / 4.0).ln();
        weight += r.weight;
    }
    sum / weight
}

/// Triangles whose planar image is not positively oriented.
pub fn flips(triangles: &[[u32; 3]], uv: &[[f64; 2]]) -> usize {
    triangles.iter().filter(|&&t| signed_area2(planar(uv, t)) <= 0.0 || signed_area2(planar(uv, t)).is_nan()).count()
}

/// Squared L2 stretch (times the square of the global scale) of one triangle.
pub(crate) fn triangle_stretch(positions: &[[f64; 3]], t: [u32; 3], uv: &[[f64; 2]]) -> f64 {
    let [a, b, c] = t.map(|v| positions[v as usize]);
    let p = planar(uv, t);
    let det = signed_area2(p);
    let det = if det.abs() < 1e-280 { 1e-280 } else { det };
    let mut sum = 0.0;
    for i in 0..3 {
        let ss = (a[i] * (p[1][1] - p[2][1]) + b[i] * (p[2][1] - p[0][1]) + c[i] * (p[0][1] - p[1][1])) / det;
        let st = (a[i] * (p[2][0] - p[1][0]) + b[i] * (p[0][0] - p[2][0]) + c[i] * (p[1][0] - p[0][0])) / det;
        sum += ss * ss + st * st;
    }
    sum.min(1e200)
}

/// The quality of a finished map.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Distortion {
    /// L2 geometric stretch (Sander et al. 2001) of plane -> surface, 1 for an isometry up to scale.
    pub l2: f64,
    /// Largest singular value of plane -> surface, at the same scale.
    pub linf: f64,
    /// Mean symmetric Dirichlet density at the area-preserving scale, 4 for an isometry.
    pub symmetric_dirichlet: f64,
    /// Triangles not positively oriented.
    pub flips: usize,
}

/// Measures a map. Degenerate triangles are left out of the means, not of the flips.
pub fn measure(positions: &[[f64; 3]], triangles: &[[u32; 3]], uv: &[[f64; 2]]) -> Distortion {
    let (mut surface, mut plane) = (0.0, 0.0);
    let mut terms = Vec::with_capacity(triangles.len());
    for &t in triangles {
        let [a, b, c] = t.map(|v| positions[v as usize]);
        let p = planar(uv, t);
        let a3 = 0.5 * norm(cross(sub(b, a), sub(c, a)));
        let a2 = 0.5 * signed_area2(p);
        surface += a3;
        plane += a2.abs();
        terms.push((t, a3, a2));
    }
    let scale = (plane / surface.max(1e-300)).sqrt();
    let (mut l2, mut linf, mut sd, mut weight) = (0.0, 0.0f64, 0.0, 0.0);
    for (t, a3, a2) in terms {
        if a3 <= 1e-14 * surface || a2 <= 1e-14 * plane {
            continue;
        }
        let [a, b, c] = t.map(|v| positions[v as usize]);
        let [p, q, r] = planar(uv, t);
        let k = 0.5 / a2 * scale;
        let d = |i: usize| {
            let ss = (a[i] * (q[1] - r[1]) + b[i] * (r[1] - p[1]) + c[i] * (p[1] - q[1])) * k;
            let st = (a[i] * (r[0] - q[0]) + b[i] * (p[0] - r[0]) + c[i] * (q[0] - p[0])) * k;
            (ss, st)
        };
        let (x, y, z) = (d(0), d(1), d(2));
        let (e, f, g) =
            (x.0 * x.0 + y.0 * y.0 + z.0 * z.0, x.0 * x.1 + y.0 * y.1 + z.0 * z.1, x.1 * x.1 + y.1 * y.1 + z.1 * z.1);
        let root = ((e - g) * (e - g) + 4.0 * f * f).sqrt();
        let (s1, det2) = (0.5 * (e + g + root), (e * g - f * f).max(1e-300));
        l2 += a3 * 0.5 * (e + g);
        linf = linf.max(s1.sqrt());
        sd += a3 * (e + g) * (1.0 + 1.0 / det2);
        weight += a3;
    }
    let weight = weight.max(1e-300);
    Distortion { l2: (l2 / weight).sqrt(), linf, symmetric_dirichlet: sd / weight, flips: flips(triangles, uv) }
}

#[cfg(test)]
mod tests {
    use super::*;

    const SQUARE: [[f64; 3]; 4] = [[0.0, 0.0, 0.0], [2.0, 0.0, 0.0], [2.0, 2.0, 0.0], [0.0, 2.0, 0.0]];
    const HALVES: [[u32; 3]; 2] = [[0, 1, 2], [0, 2, 3]];

    #[test]
    fn an_isometry_scores_best() {
        let uv = SQUARE.map(|p| [p[0] * 5.0, p[1] * 5.0]);
        let d = measure(&SQUARE, &HALVES, &uv);
        assert!((d.l2 - 1.0).abs() < 1e-12 && (d.symmetric_dirichlet - 4.0).abs() < 1e-12 && d.flips == 0);
        let rest = rest_shapes(&SQUARE, &HALVES, &[1.0; 4], 5.0);
        assert!((energy(&rest, &HALVES, &uv) - 4.0).abs() < 1e-12);
    }

    #[test]
    fn a_stretch_by_two_scores_as_by_hand() {
        // Singular values of plane -> surface at equal area: sqrt 2 and 1 / sqrt 2.
        let uv = SQUARE.map(|p| [p[0] * 2.0, p[1]]);
        let d = measure(&SQUARE, &HALVES, &uv);
        assert!((d.l2 - 1.25f64.sqrt()).abs() < 1e-12 && (d.linf - 2f64.sqrt()).abs() < 1e-12);
        assert!((d.symmetric_dirichlet - 5.0).abs() < 1e-12);
    }

    #[test]
    fn a_mirrored_map_is_all_flips() {
        let uv = SQUARE.map(|p| [-p[0], p[1]]);
        assert_eq!(flips(&HALVES, &uv), 2);
        assert_eq!(energy(&rest_shapes(&SQUARE, &HALVES, &[1.0; 4], 1.0), &HALVES, &uv), f64::INFINITY);
    }

    #[test]
    fn rest_shapes_at_several_scales_in_turn_are_those_made_for_each() {
        let wanted = [1.0, 2.0, 0.5, 1.5];
        let mut kept = RestShapes::new(&SQUARE, &HALVES, &wanted);
        for scale in [1.0, 5.0, 0.3, 0.3] {
            kept.set_scale(scale);
            let made = rest_shapes(&SQUARE, &HALVES, &wanted, scale);
            for (a, b) in kept.shapes.iter().zip(&made) {
                assert!((a.weight - b.weight).abs() < 1e-15);
                let near = |(x, y): (&f64, &f64)| (x - y).abs() < 1e-12 * (1.0 + y.abs());
                assert!(a.g.as_flattened().iter().zip(b.g.as_flattened()).all(near), "{scale}: {a:?} {b:?}");
            }
        }
        assert!((kept.areas.iter().sum::<f64>() - kept.area).abs() < 1e-15);
    }
}
