//! A flip-free map to start from: convex combinations, reweighted by stretch.
//!
//! A map that puts every inner vertex at a positively weighted mean of its neighbours, with the boundary on a convex
//! polygon, has no flips (Tutte 1963, Floater 1997). The weights are Floater's mean-value weights (2003), made symmetric
//! so that Cholesky serves; after each solve they are divided by the stretch around the edge and solved again
//! (Yoshizawa, Belyaev, Seidel 2004, with their vertex weights split over the edge to keep the symmetry).

use super::Shape;
use super::distortion::{RestShapes, flips, mean, triangle_stretch};
use super::system::System;
use crate::base::vec3::{cross, dot, norm, sub};

/// Largest number of reweighting passes.
const MAX_PASSES: usize = 10;

/// Symmetric mean-value weights in the order of `edges`; all positive.
fn mean_value_weights(positions: &[[f64; 3]], triangles: &[[u32; 3]], edges: &[[u32; 2]]) -> Vec<f64> {
    let mut weights = vec![0.0; edges.len()];
    for t in triangles {
        for k in 0..3 {
            let (a, b, c) = (t[k], t[(k + 1) % 3], t[(k + 2) % 3]);
            let (u, v) =
                (sub(positions[b as usize], positions[a as usize]), sub(positions[c as usize], positions[a as usize]));
            let (lu, lv) = (norm(u), norm(v));
            let tangent = norm(cross(u, v)) / (lu * lv + dot(u, v)).max(1e-12 * lu * lv).max(1e-300);
            for (x, l) in [(b, lu), (c, lv)] {
                if let Ok(e) = edges.binary_search(&[a.min(x), a.max(x)]) {
                    weights[e] += tangent / l.max(1e-300);
                }
            }
        }
    }
    // Cap the spread: a zero or huge weight would lose the guarantee to rounding.
    let mut sorted: Vec<f64> = weights.iter().copied().filter(|w| w.is_finite()).collect();
    sorted.sort_unstable_by(f64::total_cmp);
    let median = sorted.get(sorted.len() / 2).copied().unwrap_or(1.0).max(1e-300);
    weights.iter().map(|w| if w.is_finite() { w.clamp(1e-4 * median, 1e4 * median) } else { median }).collect()
}

/// The map that a solve starts from.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) enum Start {
    /// The map that `uv` holds, which has no flips.
    Map,
    /// A convex combination map, reweighted by stretch.
    Convex {
        /// Reweighting passes, 1 to 10; with 1 it is the plain mean-value map.
        passes: usize,
    },
    /// As [`Start::Convex`], but `uv` holds the plain mean-value map, the result of its first pass.
    Plain {
        /// Reweighting passes, the first of them included.
        passes: usize,
    },
}

impl Start {
    fn passes(self) -> usize {
        match self {
            Start::Map => 0,
            Start::Convex { passes } | Start::Plain { passes } => passes,
        }
    }
}

/// How the start was made.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(crate) struct StartRecord {
    /// Reweighting passes made.
    pub passes: usize,
    /// Uniform weights were used, not mean-value weights.
    pub uniform: bool,
}

/// Fills in the free vertices of `uv`, whose fixed ones lie on a convex polygon: with mean-value weights, or with uniform
/// weights if those give flips from rounding. Keeps the flip-free pass of least stretch. `None` if no pass was free of
/// flips in f64.
pub(crate) fn convex(system: &mut System, shape: Shape<'_>, uv: &mut [[f64; 2]], start: Start) -> Option<StartRecord> {
    weighted(system, shape, uv, start, false)
        .or_else(|| weighted(system, shape, uv, Start::Convex { passes: start.passes() }, true))
}

/// [`convex`] with one kind of weights only.
pub(super) fn weighted(
    system: &mut System,
    shape: Shape<'_>,
    uv: &mut [[f64; 2]],
    start: Start,
    uniform: bool,
) -> Option<StartRecord> {
    let rest = system.rest.get_or_insert_with(|| RestShapes::new(shape.positions, shape.triangles, shape.wanted));
    let area = std::mem::take(&mut rest.areas);
    let found = reweighted(system, shape, &area, uv, start, uniform);
    if let Some(rest) = &mut system.rest {
        rest.areas = area;
    }
    found
}

/// [`weighted`] with the areas of the triangles at rest.
fn reweighted(
    system: &mut System,
    shape: Shape<'_>,
    area: &[f64],
    uv: &mut [[f64; 2]],
    start: Start,
    uniform: bool,
) -> Option<StartRecord> {
    let Shape { positions, triangles, wanted, .. } = shape;
    let mut around = vec![1e-300; positions.len()];
    for (t, a) in triangles.iter().zip(area) {
        t.iter().for_each(|&v| around[v as usize] += a);
    }
    let total: f64 = area.iter().sum::<f64>().max(1e-300);
    let mut weights = if uniform {
        vec![1.0; system.edges.len()]
    } else {
        let kept = system.weights.take();
        kept.unwrap_or_else(|| mean_value_weights(positions, triangles, &system.edges))
    };
    if !uniform {
        system.weights = Some(weights.clone());
    }
    let mut best: Option<(f64, Vec<[f64; 2]>)> = None;
    let mut made = 0;
    let passes = start.passes().clamp(1, MAX_PASSES);
    for pass in 0..passes {
        let plain = pass == 0 && !uniform;
        let there = plain && matches!(start, Start::Plain { .. });
        if !there && !system.solve_weighted(&weights, plain, uv) {
            break;
        }
        made = pass + 1;
        if passes == 1 {
            // Nothing to compare it with.
            return (flips(triangles, uv) == 0).then_some(StartRecord { passes, uniform });
        }
        let s2: Vec<f64> =
            triangles.iter().map(|&t| mean(wanted, t).powi(2) * triangle_stretch(positions, t, uv)).collect();
        let average = (s2.iter().zip(area).map(|(s, a)| s * a).sum::<f64>() / total).sqrt();
        if flips(triangles, uv) == 0 {
            if best.as_ref().is_none_or(|b| average < b.0) {
                best = Some((average, uv.to_vec()));
            } else if best.as_ref().is_some_and(|b| average > 1.02 * b.0) {
                break;
            }
        }
        if made == passes {
            break;
        }
        let mut vertex = vec![0.0; positions.len()];
        for ((t, a), s) in triangles.iter().zip(area).zip(&s2) {
            t.iter().for_each(|&v| vertex[v as usize] += a * s);
        }
        let sigma: Vec<f64> = vertex.iter().zip(&around).map(|(s, a)| (s / a).sqrt().max(1e-6 * average)).collect();
        for (w, e) in weights.iter_mut().zip(&system.edges) {
            *w /= (sigma[e[0] as usize] * sigma[e[1] as usize]).sqrt() / average;
        }
        let top = weights.iter().copied().fold(0.0, f64::max);
        weights.iter_mut().for_each(|w| *w = (*w / top).max(1e-12));
    }
    let (_, kept) = best?;
    uv.copy_from_slice(&kept);
    Some(StartRecord { passes: made, uniform })
}
