//! Coarse images of wrinkled cloth: the lengths that wrinkles between coarse texels have taken up.

use super::Motion;
use crate::cloth::{Cloth, other_end};
use crate::number::real::{dot, sub};

/// Rounds over all springs, forward and backward by turns.
pub const ROUNDS: usize = 8;
/// Share of the shortest spring at a particle by which it moves at most.
pub const MOST: f64 = 0.25;

fn len(way: [f64; 3]) -> f64 {
    dot(way, way).sqrt()
}

/// A spring between two points of a cloth.
struct Spring {
    ends: [usize; 2],
    rest: f64,
    /// Shares of a correction.
    share: [f64; 2],
}

/// Moves the particles of a coarse image apart until springs are no shorter than they are at rest. Wrinkles that a coarse image cannot have
/// leave its springs too short, and the first step would throw the cloth apart. Previous positions move along, so velocities stay.
pub fn settle(cloth: &Cloth, motion: &mut Motion) {
    let points: Vec<usize> = cloth.points().into_iter().map(|k| k as usize).collect();
    let (springs, most) = springs(cloth, &points);
    let start: Vec<[f64; 3]> = motion.now.iter().map(|p| [0, 1, 2].map(|c| f64::from(p[c]))).collect();
    let mut at = start.clone();
    for round in 0..ROUNDS {
        let mut any = false;
        for n in 0..springs.len() {
            let Spring { ends: [a, b], rest, share } = &springs[if round % 2 == 0 { n } else { springs.len() - 1 - n }];
            let way = sub(at[*b], at[*a]);
            let long = len(way);
            if !(long > 1e-6 * rest && long < *rest) {
                continue;
            }
            any = true;
            let by = (rest - long) / long;
            for c in 0..3 {
                at[*a][c] -= share[0] * by * way[c];
                at[*b][c] += share[1] * by * way[c];
            }
        }
        for (k, p) in at.iter_mut().enumerate() {
            let way = sub(*p, start[k]);
            let scale = most[k] / len(way);
            if scale < 1.0 {
                *p = [0, 1, 2].map(|c| start[k][c] + scale * way[c]);
            }
        }
        if !any {
            break;
        }
    }
    for (k, point) in points.iter().enumerate() {
        for c in 0..3 {
            let by = (at[*point][c] - start[*point][c]) as f32;
            motion.now[k][c] += by;
            motion.before[k][c] += by;
        }
    }
}

/// All springs, between the first duplicates of seam points, and how far \[m\] each point may move.
fn springs(cloth: &Cloth, points: &[usize]) -> (Vec<Spring>, Vec<f64>) {
    let mut springs = Vec::new();
    let mut most = vec![f64::INFINITY; cloth.len()];
    for (ends, rest) in lengths(cloth, points) {
        let weight = ends.map(|k| f64::from(cloth.inverse_mass(k)).max(0.0));
        let sum = weight[0] + weight[1];
        if sum > 0.0 {
            ends.iter().for_each(|k| most[*k] = most[*k].min(MOST * rest));
            springs.push(Spring { ends, rest, share: weight.map(|w| w / sum) });
        }
    }
    (springs, most)
}

/// The points that each spring joins, and its rest length \[m\].
pub fn lengths(cloth: &Cloth, points: &[usize]) -> impl Iterator<Item = ([usize; 2], f64)> {
    cloth.grids().iter().enumerate().flat_map(move |(g, grid)| {
        let (w, h) = (grid.width as usize, grid.height as usize);
        let all = (0..grid.texels()).flat_map(|k| (0..4).map(move |d| (k, d)));
        all.filter_map(move |(k, d)| {
            let (rest, other) = (f64::from(cloth.spring(g, k, d)), other_end(w, h, k, d)?);
            // Duplicates of one point may be neighbours.
            let ends = [k, other].map(|k| points[grid.first as usize + k]);
            (rest > 0.0 && ends[0] != ends[1]).then_some((ends, rest))
        })
    })
}
