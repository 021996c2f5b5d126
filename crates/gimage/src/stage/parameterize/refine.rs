//! Coarse to fine: the map of a simplified disk, whose vertices come back one by one (Hormann, Greiner, Campagna 1999;
//! the order of Hoppe's progressive meshes 1996).
//!
//! A vertex comes back into the kernel of the polygon around it, which is never empty: seen from the vertex it had been
//! collapsed into, all of the polygon was in sight. There it goes to the least energy of its own triangles. Whenever the
//! mesh has doubled, and at the end, every vertex does so in turn: what is left to do is short-range by then, and needs no
//! linear system of the size of the mesh.

use super::distortion::{Rest, energy, flips, log_distortion, planar, rest_area, rest_shape};
use super::distortion::{rest_shapes, signed_area2};
use super::local::{room, settle, turns};
use super::newton::{NewtonOptions, NewtonRecord};
use super::whole::whole;
use super::{POOR_START, ParameterizeRecord, Shape, Way};
use crate::base::decimate::hierarchy;

/// Turns of all vertices whenever the mesh has doubled. Twice as many lower the energy by a thousandth.
const TURNS: usize = 2;
/// Newton steps of a vertex that comes back.
const STEPS: usize = 2;
/// Largest energy of the whole, in units of that of the simplified disk: above it a shape was lost on the way, as the rim
/// is of a shell thinner than its edges are long.
const WORSE: f64 = 1.05;

/// Largest energy of the map of the simplified disk: above it the map is poor, whatever the whole makes of it.
const SANE: f64 = 100.0;

/// As [`super::parameterize`], by way of a disk of about `target` triangles; the steps recorded are those of its map.
/// `None` also where the simplified disk has no sane map, where a vertex has no room to come back, and where the whole
/// does not come near the energy of the simpler disk.
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
        whole(shape, &mut small_uv, passes, options, POOR_START)?
    };
    if record.newton.end > SANE {
        return None;
    }
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
    for k in (0..now.collapses.len()).rev() {
        let [u, _] = now.collapses[k];
        fan.clear();
        left += now.undo(k, |t| fan.push((t, rest_shape(positions, t, wanted, scale))));
        uv[u as usize] = room(u, fan.iter().map(|x| x.0), uv)?;
        settle(u, fan.iter().map(|x| (x.0, &x.1)), uv, STEPS, false);
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
    record.way = Way::CoarseToFine;
    record.log_distortion = log_distortion(&rest, triangles, uv);
    (flips(triangles, uv) == 0 && record.newton.end <= WORSE * coarse).then_some(record)
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::base::shapes;
    use proptest::prelude::*;

    /// The rim of a sheet, and where it goes on a square.
    fn placed(s: &crate::base::surface::Surface, side: f64) -> (Vec<bool>, Vec<[f64; 2]>) {
        (shapes::rim(s), s.positions.iter().map(|p| [side * p[0], side * p[1]]).collect())
    }

    fn bumpy(n: u32, height: f64) -> crate::base::surface::Surface {
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
        let (mut all, mut fine) = (start.clone(), start);
        let map = whole(shape, &mut all, 8, &options, f64::INFINITY).unwrap();
        let part = coarse_to_fine(shape, &mut fine, 8, &options, 900).unwrap();
        assert_eq!(flips(&s.triangles, &fine), 0);
        assert!(fixed.iter().zip(all.iter().zip(&fine)).all(|(f, (a, b))| !f || a == b), "the boundary moved");
        let above = (part.newton.end - 4.0) / (map.newton.end - 4.0);
        assert!((0.999..1.01).contains(&above), "{} {}", part.newton.end, map.newton.end);
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
