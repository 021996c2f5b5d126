//! How densely texels are wanted where: more where the surface bends.
//!
//! The distance between a surface and flat pieces of size h on it is about `|K| h^2 / 8`, K the curvature tensor, so the
//! least mean square for a number of texels has h proportional to `|K|^(-1/3)` (the signal-specialised metric of Sander,
//! Gortler, Snyder, Hoppe 2002, made isotropic). K is the average over about a texel of the dihedral angles
//! (Cohen-Steiner, Morvan 2003): what is finer than texels can show does not count.

use crate::base::graph::EdgeGraph;
use crate::base::surface::Surface;
use crate::base::vec3::{cross, dot, norm, scale, sub};

/// Bending under this share of the mean is as good as flat.
const FLAT: f64 = 0.2;
/// Radii of curvature over this many diagonals are flat whatever the rest.
const RADIUS: f64 = 20.0;
/// Most rounds of averaging.
const ROUNDS: f64 = 24.0;

/// For each vertex the length that a unit of length counts for (square mean 1 over the surface). `spacing` is the mean
/// distance of texels \[m\]; `detail` from 0 (all ones) to 1 (least square error). O(n) for each of at most 24 rounds.
pub(crate) fn wanted(surface: &Surface, graph: &EdgeGraph, spacing: f64, detail: f64) -> Vec<f64> {
    let n = surface.positions.len();
    if detail <= 0.0 {
        return vec![1.0; n];
    }
    let normals: Vec<[f64; 3]> = (0..surface.triangles.len())
        .map(|t| {
            let [a, b, c] = surface.corners(t);
            cross(sub(b, a), sub(c, a))
        })
        .collect();
    // Six entries of the angle-weighted tensor and the area.
    let mut at = vec![[0.0; 7]; n];
    let mut area = vec![0.0; n];
    for (t, m) in surface.triangles.iter().zip(&normals) {
        t.iter().for_each(|&v| area[v as usize] += norm(*m) / 6.0);
    }
    at.iter_mut().zip(&area).for_each(|(x, a)| x[6] = *a);
    let mut mean = 0.0;
    for (e, &[a, b]) in graph.ends.iter().enumerate().filter(|x| !graph.is_boundary(x.0)) {
        let length = graph.length[e];
        mean += length / graph.ends.len() as f64;
        let [h, w] = graph.halves[e];
        let (p, q) = (normals[h as usize / 3], normals[w as usize / 3]);
        // The same way round both triangles mean to turn one of them over.
        let same =
            surface.triangles[h as usize / 3][h as usize % 3] == surface.triangles[w as usize / 3][w as usize % 3];
        let q = if same { scale(q, -1.0) } else { q };
        let along = sub(surface.positions[b as usize], surface.positions[a as usize]);
        let forward = surface.triangles[h as usize / 3][h as usize % 3] == a;
        let turn = dot(cross(p, q), along) * if forward { 1.0 } else { -1.0 };
        let angle = norm(cross(p, q)).atan2(dot(p, q)).copysign(turn);
        let weight = 0.5 * angle / length.max(1e-300);
        let [x, y, z] = along;
        for v in [a, b] {
            let t = &mut at[v as usize];
            for (t, m) in t.iter_mut().zip([x * x, y * y, z * z, x * y, x * z, y * z]) {
                *t += weight * m;
            }
        }
    }
    let rounds = (spacing / mean.max(1e-300)).powi(2).clamp(2.0, ROUNDS) as usize;
    for _ in 0..rounds {
        at = spread(graph, &at);
    }
    let total: f64 = area.iter().sum::<f64>().max(1e-300);
    let bend: Vec<f64> = at
        .iter()
        .map(|t| {
            let square: f64 =
                t[..3].iter().map(|x| x * x).sum::<f64>() + 2.0 * t[3..6].iter().map(|x| x * x).sum::<f64>();
            square / (t[6] * t[6]).max(1e-300)
        })
        .collect();
    let mean = bend.iter().zip(&area).map(|(b, a)| b.sqrt() * a).sum::<f64>() / total;
    let flat = (FLAT * mean).max(1.0 / (RADIUS * diagonal(&surface.positions)).max(1e-300)).powi(2);
    let mut out: Vec<f64> = bend.iter().map(|b| (b + flat).powf(detail / 6.0)).collect();
    let square = out.iter().zip(&area).map(|(s, a)| s * s * a).sum::<f64>() / total;
    out.iter_mut().for_each(|s| *s /= square.max(1e-300).sqrt());
    out
}

/// One round of averaging that keeps the sums: half of each vertex's share goes to its neighbours.
fn spread(graph: &EdgeGraph, at: &[[f64; 7]]) -> Vec<[f64; 7]> {
    let mut out: Vec<[f64; 7]> = at.iter().map(|x| x.map(|x| 0.5 * x)).collect();
    for (v, x) in at.iter().enumerate() {
        let around = graph.neighbours(v as u32);
        let part = 0.5 / around.len().max(1) as f64;
        for &(w, _) in around {
            out[w as usize].iter_mut().zip(x).for_each(|(o, x)| *o += part * x);
        }
    }
    out
}

fn diagonal(positions: &[[f64; 3]]) -> f64 {
    let (mut lo, mut hi) = ([f64::INFINITY; 3], [f64::NEG_INFINITY; 3]);
    for p in positions {
        (0..3).for_each(|c| (lo[c], hi[c]) = (lo[c].min(p[c]), hi[c].max(p[c])));
    }
    norm(sub(hi, lo))
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::base::shapes;

    fn of(s: &Surface, detail: f64) -> Vec<f64> {
        wanted(s, &EdgeGraph::new(&s.positions, &s.triangles), (s.area() / 1000.0).sqrt(), detail)
    }

    #[test]
    fn what_bends_nowhere_or_alike_everywhere_is_wanted_alike_everywhere() {
        for s in [shapes::rectangle(9, 7, 3.0, 2.0), shapes::tube(40, 30, 4.0)] {
            assert!(of(&s, 1.0).iter().all(|w| (w - 1.0).abs() < 0.05), "{:?}", of(&s, 1.0));
        }
        assert!(of(&shapes::torus(24, 16), 0.0).iter().all(|w| *w == 1.0));
    }

    #[test]
    fn bends_are_wanted_denser_by_the_cube_root_of_the_curvature_whatever_size_place_and_side() {
        // A quarter turn of radius 1/4 between two flats.
        let bent = |v: f64| {
            let (r, s) = (0.25, 2.0 * v - 1.0);
            let half = 0.25 * std::f64::consts::PI * r;
            let a = (s / r).clamp(-half / r, half / r);
            let beyond = s - a * r;
            [r * a.sin() + beyond * a.cos(), r * a.cos() - beyond * a.sin()]
        };
        let sheet = shapes::sheet(20, 160, shapes::Join::Open, shapes::Join::Open, |u, v| {
            let [x, z] = bent(v);
            [x, u, z]
        });
        let w = of(&sheet, 1.0);
        let at = |k: f64| w[(k * 160.0) as usize * 21 + 10];
        let flat = 0.2 * (0.5 * std::f64::consts::PI * 0.25 / 2.0) / 0.25;
        let ratio = ((16.0 + flat * flat) / (flat * flat)).powf(1.0 / 6.0);
        assert!((at(0.5) / at(0.1) / ratio - 1.0).abs() < 0.05, "{} {ratio}", at(0.5) / at(0.1));
        let mut other = sheet.clone();
        other.positions.iter_mut().for_each(|p| *p = [7.0 - 1e3 * p[1], 3.0 + 1e3 * p[0], 1e3 * p[2]]);
        other.triangles.iter_mut().for_each(|t| t.swap(0, 1));
        assert!(w.iter().zip(of(&other, 1.0)).all(|(a, b)| (a - b).abs() < 1e-6));
    }
}
