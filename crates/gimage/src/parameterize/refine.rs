//! Coarse to fine: the map of a simplified disk, whose vertices come back one by one (Hormann, Greiner, Campagna 1999;
//! the order of Hoppe's progressive meshes 1996).
//!
//! A vertex comes back into the kernel of the polygon around it, which is never empty: seen from the vertex it had been
//! collapsed into, all of the polygon was in sight. There it goes to the least energy of its own triangles. Whenever the
//! mesh has doubled, and at the end, every vertex does so in turn: what is left to do is short-range by then, and needs no
//! linear system of the size of the mesh.

use super::distortion::{Rest, density, energy, flips, jacobian, log_distortion, planar, rest_area, rest_shape};
use super::distortion::{rest_shapes, signed_area2};
use super::newton::{Local, NewtonOptions, NewtonRecord, local};
use super::{ParameterizeRecord, Shape, parameterize};
use crate::decimate::hierarchy;
use crate::fit::clip;

/// Turns of all vertices whenever the mesh has doubled. Twice as many lower the energy by a thousandth.
const TURNS: usize = 2;
/// Newton steps of a vertex that comes back.
const STEPS: usize = 2;
/// Largest energy of the whole, in units of that of the simplified disk: above it a shape was lost on the way, as the rim
/// is of a shell thinner than its edges are long.
const WORSE: f64 = 1.05;

/// As [`parameterize`], by way of a disk of about `target` triangles; the steps recorded are those of its map. `None` also
/// where a vertex has no room to come back, and where the whole does not come near the energy of the simpler disk.
/// O(n log n) and the map of the simpler disk.
pub(super) fn coarse_to_fine(
    shape: Shape<'_>,
    uv: &mut [[f64; 2]],
    passes: usize,
    options: &NewtonOptions,
    target: usize,
) -> Option<ParameterizeRecord> {
    let Shape { positions, triangles, wanted, fixed } = shape;
    let mut now = hierarchy(positions, triangles, fixed, target);
    let (vertex, coarse) = now.coarse(positions.len());
    let mut small_uv: Vec<[f64; 2]> = vertex.iter().map(|&v| uv[v as usize]).collect();
    let mut record = {
        let positions: Vec<[f64; 3]> = vertex.iter().map(|&v| positions[v as usize]).collect();
        let wanted: Vec<f64> = vertex.iter().map(|&v| wanted[v as usize]).collect();
        let fixed: Vec<bool> = vertex.iter().map(|&v| fixed[v as usize]).collect();
        let shape = Shape { positions: &positions, triangles: &coarse, wanted: &wanted, fixed: &fixed };
        parameterize(shape, &mut small_uv, passes, options, usize::MAX / 2)?
    };
    vertex.iter().zip(&small_uv).for_each(|(&v, p)| uv[v as usize] = *p);
    let plane: f64 = coarse.iter().map(|&t| 0.5 * signed_area2(planar(&small_uv, t))).sum();
    let surface: f64 = triangles.iter().map(|&t| rest_area(positions, t, wanted)).sum();
    let scale = (plane / surface.max(1e-300)).sqrt();
    let (mut left, mut level) = (coarse.len(), triangles.len());
    // Halves, quarters, ... of the whole.
    while level > 2 * left {
        level /= 2;
    }
    drop((vertex, coarse, small_uv));
    let mut fan: Vec<([u32; 3], Rest)> = Vec::new();
    for (k, &[u, v]) in now.collapses.iter().enumerate().rev() {
        let from = k.checked_sub(1).map_or(0, |k| now.ends[k]);
        fan.clear();
        for &t in &now.fans[from as usize..now.ends[k] as usize] {
            let t = t as usize;
            if now.alive[t] {
                now.triangles[t] = now.triangles[t].map(|x| if x == v { u } else { x });
            } else {
                now.alive[t] = true;
                left += 1;
            }
            fan.push((now.triangles[t], rest_shape(positions, now.triangles[t], wanted, scale)));
        }
        uv[u as usize] = room(u, &fan, uv)?;
        settle(u, fan.iter().map(|x| (x.0, &x.1)), uv, STEPS);
        if left >= level && left < triangles.len() {
            level *= 2;
            let there = now.now();
            let rest = rest_shapes(positions, &there, wanted, scale);
            turns(&there, &rest, fixed, uv, TURNS);
        }
    }
    drop(now);
    let rest = rest_shapes(positions, triangles, wanted, scale);
    let start = energy(&rest, triangles, uv);
    turns(triangles, &rest, fixed, uv, TURNS);
    let coarse = record.newton.end;
    record.newton = NewtonRecord { start, end: energy(&rest, triangles, uv), ..record.newton };
    record.log_distortion = log_distortion(&rest, triangles, uv);
    (flips(triangles, uv) == 0 && record.newton.end <= WORSE * coarse).then_some(record)
}

/// The middle of the places where all triangles around `u` are turned the right way.
fn room(u: u32, fan: &[([u32; 3], Rest)], uv: &[[f64; 2]]) -> Option<[f64; 2]> {
    let (mut lo, mut hi) = ([f64::INFINITY; 2], [f64::NEG_INFINITY; 2]);
    let mut sides = Vec::with_capacity(fan.len());
    for (t, _) in fan {
        let k = t.iter().position(|&x| x == u)?;
        let (a, b) = (uv[t[(k + 1) % 3] as usize], uv[t[(k + 2) % 3] as usize]);
        for c in 0..2 {
            lo[c] = lo[c].min(a[c]).min(b[c]);
            hi[c] = hi[c].max(a[c]).max(b[c]);
        }
        sides.push((a, b));
    }
    let mut polygon = vec![lo, [hi[0], lo[1]], hi, [lo[0], hi[1]]];
    let mut next = Vec::new();
    for (a, b) in sides {
        let (n, d) = ([b[1] - a[1], a[0] - b[0]], a[0] * b[1] - a[1] * b[0]);
        clip(&polygon, n, d, &mut next);
        std::mem::swap(&mut polygon, &mut next);
    }
    if polygon.len() < 3 {
        return None;
    }
    let n = polygon.len() as f64;
    let middle = polygon.iter().fold([0.0; 2], |m, p| [m[0] + p[0] / n, m[1] + p[1] / n]);
    Some(middle)
}

/// Moves `u` down the energy of its own triangles, never over a flip.
fn settle<'a>(u: u32, fan: impl Iterator<Item = ([u32; 3], &'a Rest)> + Clone, uv: &mut [[f64; 2]], steps: usize) {
    let at = |uv: &[[f64; 2]], t: [u32; 3], p: [f64; 2]| t.map(|x| if x == u { p } else { uv[x as usize] });
    let energy = |uv: &[[f64; 2]], p: [f64; 2]| -> f64 {
        fan.clone().map(|(t, r)| r.weight * density(jacobian(r, at(uv, t, p)))).sum()
    };
    let mut p = uv[u as usize];
    let mut now = energy(uv, p);
    for _ in 0..steps {
        let (mut g, mut h) = ([0.0; 2], [0.0; 3]);
        for (t, r) in fan.clone() {
            let Local { gradient, own, .. } = local(r, at(uv, t, p));
            let k = usize::from(t[1] == u) + 2 * usize::from(t[2] == u);
            g = [g[0] + gradient[k][0], g[1] + gradient[k][1]];
            let b = own[k];
            h = [h[0] + b[0], h[1] + b[1], h[2] + b[3]];
        }
        let det = h[0] * h[2] - h[1] * h[1];
        let d = [(h[1] * g[1] - h[2] * g[0]) / det, (h[1] * g[0] - h[0] * g[1]) / det];
        if !(d[0].is_finite() && d[1].is_finite()) {
            break;
        }
        let mut step = 1.0;
        let mut moved = false;
        for _ in 0..12 {
            let q = [p[0] + step * d[0], p[1] + step * d[1]];
            let e = energy(uv, q);
            if e < now {
                (p, now, moved) = (q, e, true);
                break;
            }
            step *= 0.5;
        }
        if !moved {
            break;
        }
    }
    uv[u as usize] = p;
}

/// Every free vertex settles in turn, `count` times.
fn turns(triangles: &[[u32; 3]], rest: &[Rest], fixed: &[bool], uv: &mut [[f64; 2]], count: usize) {
    let mut first = vec![0u32; fixed.len() + 1];
    triangles.iter().flatten().for_each(|&v| first[v as usize + 1] += 1);
    (0..fixed.len()).for_each(|v| first[v + 1] += first[v]);
    let mut next = first.clone();
    let mut around = vec![0u32; 3 * triangles.len()];
    for (t, tri) in triangles.iter().enumerate() {
        for &v in tri {
            around[next[v as usize] as usize] = t as u32;
            next[v as usize] += 1;
        }
    }
    drop(next);
    for _ in 0..count {
        for v in (0..fixed.len()).filter(|&v| !fixed[v]) {
            let fan = &around[first[v] as usize..first[v + 1] as usize];
            settle(v as u32, fan.iter().map(|&t| (triangles[t as usize], &rest[t as usize])), uv, 1);
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::shapes;
    use proptest::prelude::*;

    /// The rim of a sheet, and where it goes on a square.
    fn placed(s: &crate::surface::Surface, side: f64) -> (Vec<bool>, Vec<[f64; 2]>) {
        (shapes::rim(s), s.positions.iter().map(|p| [side * p[0], side * p[1]]).collect())
    }

    fn bumpy(n: u32, height: f64) -> crate::surface::Surface {
        shapes::sheet(n, n, shapes::Join::Open, shapes::Join::Open, |u, v| {
            [u, v, height * (7.0 * u).sin() * (5.0 * v + u).cos()]
        })
    }

    #[test]
    fn coarse_to_fine_ends_where_the_whole_mesh_would() {
        let s = bumpy(60, 0.15);
        let (fixed, start) = placed(&s, 64.0);
        let wanted: Vec<f64> = s.positions.iter().map(|p| 1.0 + 0.5 * p[0]).collect();
        let shape = Shape { positions: &s.positions, triangles: &s.triangles, wanted: &wanted, fixed: &fixed };
        let options = NewtonOptions::default();
        let (mut whole, mut fine) = (start.clone(), start);
        let all = parameterize(shape, &mut whole, 8, &options, usize::MAX / 2).unwrap();
        let part = coarse_to_fine(shape, &mut fine, 8, &options, 900).unwrap();
        assert_eq!(flips(&s.triangles, &fine), 0);
        assert!(fixed.iter().zip(whole.iter().zip(&fine)).all(|(f, (a, b))| !f || a == b), "the boundary moved");
        let above = (part.newton.end - 4.0) / (all.newton.end - 4.0);
        assert!((0.999..1.01).contains(&above), "{} {}", part.newton.end, all.newton.end);
        // And what the last turns did was little: the way back leaves no kinks.
        assert!(part.newton.start - part.newton.end < 0.05 * (part.newton.end - 4.0), "{part:?}");
    }

    proptest! {
        #![proptest_config(ProptestConfig::with_cases(24))]
        #[test]
        fn nothing_flips_on_the_way_back(n in 8u32..24, height in 0.0f64..2.0, target in 0usize..200, noise in any::<u64>()) {
            let mut s = bumpy(n, height);
            let mut draw = shapes::random(noise);
            let step = 0.3 / f64::from(n);
            s.positions.iter_mut().for_each(|p| p[2] += step * (draw(1000) as f64 / 500.0 - 1.0));
            let (fixed, mut uv) = placed(&s, 32.0);
            let wanted = vec![1.0; fixed.len()];
            let shape = Shape { positions: &s.positions, triangles: &s.triangles, wanted: &wanted, fixed: &fixed };
            // A result that is worse than the coarse one is not used, but no vertex is without room either way.
            coarse_to_fine(shape, &mut uv, 4, &NewtonOptions::default(), target);
            prop_assert_eq!(flips(&s.triangles, &uv), 0);
        }
    }
}
