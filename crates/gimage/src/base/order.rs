//! An order of the vertices that comes from the shape alone: not from the file, nor from where and how it stands.
//!
//! Every choice that is free (ties, starts, numbering) follows the order of vertices. Coordinates in a frame that turns
//! with the shape give the same order for the same shape. The frame's first axis is the area's third moment `int r^2 x`
//! about its centroid, the second the fifth, `int r^4 x`, as far as it differs. A symmetric shape has no such direction;
//! then the vertex farthest out gives it, and which of several alike is taken makes no difference but by the symmetry.

use std::cmp::Ordering;

use crate::base::vec3::{add, cross, dot, norm, scale, sub};

/// Parts of the size that coordinates are rounded to, so that the last bits of a turned shape do not count.
const PARTS: f64 = 1e6;
/// A moment under this share of its bound does not define a direction.
const LEAST: f64 = 1e-4;

/// Rounds positive numbers to whole parts, 2^20 to the mean: sums are exact, so that what is equal is so to the last bit,
/// whatever the units.
pub(crate) fn whole(numbers: &[f64]) -> Vec<f64> {
    let mean = numbers.iter().sum::<f64>() / numbers.len().max(1) as f64;
    let part = f64::from(1 << 20) / mean.max(1e-300);
    numbers.iter().map(|x| (x * part).round().max(1.0)).collect()
}

/// The number that a share `p` of the others is not above; `None` of an empty list. O(n); `numbers` change places.
pub(crate) fn percentile(numbers: &mut [f32], p: f64) -> Option<f64> {
    let at = (p * numbers.len().checked_sub(1)? as f64).round() as usize;
    Some(f64::from(*numbers.select_nth_unstable_by(at, f32::total_cmp).1))
}

/// For each vertex its rounded coordinates in the frame of the shape. O(n).
pub(crate) fn places(positions: &[[f64; 3]], triangles: impl Iterator<Item = [u32; 3]> + Clone) -> Vec<[i64; 3]> {
    let corners = |t: [u32; 3]| t.map(|v| positions[v as usize]);
    let area = |[a, b, c]: [[f64; 3]; 3]| norm(cross(sub(b, a), sub(c, a)));
    let middle = |[a, b, c]: [[f64; 3]; 3]| scale(add(a, add(b, c)), 1.0 / 3.0);
    // About a vertex first: a garment far from the origin loses nothing.
    let first = positions.first().copied().unwrap_or_default();
    let (mut centre, mut total) = ([0.0; 3], 0.0);
    for t in triangles.clone() {
        let (w, m) = (area(corners(t)), sub(middle(corners(t)), first));
        centre = add(centre, scale(m, w));
        total += w;
    }
    let centre = add(first, scale(centre, 1.0 / f64::max(total, 1e-300)));
    let radius = positions.iter().map(|&p| norm(sub(p, centre))).fold(0.0, f64::max).max(1e-300);
    let local: Vec<[f64; 3]> = positions.iter().map(|&p| scale(sub(p, centre), 1.0 / radius)).collect();
    let mut moments = [[0.0; 3]; 2];
    for t in triangles {
        let w = area(corners(t)) / f64::max(total, 1e-300);
        let m = middle(t.map(|v| local[v as usize]));
        let r2 = dot(m, m);
        moments[0] = add(moments[0], scale(m, w * r2));
        moments[1] = add(moments[1], scale(m, w * r2 * r2));
    }
    let round = |x: f64| (x * PARTS).round() as i64;
    let unit = |v: [f64; 3]| scale(v, 1.0 / norm(v).max(1e-300));
    // Of the vertices farthest out those alike are told apart by `then`, and by where they stand if that is the same too.
    let farthest = |out: &dyn Fn([f64; 3]) -> [f64; 3], then: &dyn Fn([f64; 3]) -> f64| {
        let better = |a: usize, b: usize| {
            let key = |k: usize| (round(norm(out(local[k]))), round(then(local[k])));
            let place = || (0..3).fold(Ordering::Equal, |o, c| o.then(positions[b][c].total_cmp(&positions[a][c])));
            if key(b).cmp(&key(a)).then_with(place).is_gt() { b } else { a }
        };
        (0..local.len()).reduce(better).map_or([1.0, 0.0, 0.0], |k| unit(out(local[k])))
    };
    let x = match moments.into_iter().find(|m| norm(*m) > LEAST) {
        Some(m) => unit(m),
        None => farthest(&|p| p, &|_| 0.0),
    };
    let aside = |p: [f64; 3]| sub(p, scale(x, dot(p, x)));
    let y = match moments.into_iter().map(aside).find(|m| norm(*m) > LEAST) {
        Some(m) => unit(m),
        None => farthest(&aside, &|p| dot(p, x)),
    };
    let z = cross(x, y);
    local.iter().map(|&p| [round(dot(p, x)), round(dot(p, y)), round(dot(p, z))]).collect()
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::base::shapes;
    use crate::base::surface::Surface;

    fn of(s: &Surface) -> Vec<[i64; 3]> {
        places(&s.positions, s.triangles.iter().copied())
    }

    fn moved(s: &Surface, by: f64) -> Surface {
        let (sin, cos) = by.sin_cos();
        let turn = |p: [f64; 3]| {
            let q = [cos * p[0] - sin * p[1], sin * p[0] + cos * p[1], p[2]];
            [by * q[0] + 3.0, by * (cos * q[1] - sin * q[2]) - 7.0, by * (sin * q[1] + cos * q[2]) + by]
        };
        Surface { positions: s.positions.iter().map(|&p| turn(p)).collect(), ..s.clone() }
    }

    #[test]
    fn turned_moved_and_scaled_shapes_keep_their_places() {
        for seed in 0..20 {
            let s = shapes::blob(seed, 60, 3);
            let own = of(&s);
            for by in [0.001, 0.7, 2.3, 1000.0] {
                let far =
                    own.iter().zip(of(&moved(&s, by))).flat_map(|(a, b)| (0..3).map(move |c| (a[c] - b[c]).abs()));
                assert!(far.max().unwrap() <= 1, "{seed} {by}");
            }
        }
    }

    #[test]
    fn symmetric_shapes_are_placed_the_same_up_to_their_symmetry() {
        for s in [shapes::tube(12, 8, 0.7), shapes::torus(24, 16), shapes::rectangle(4, 3, 4.0, 3.0)] {
            let (mut a, mut b) = (of(&s), of(&moved(&s, 0.7)));
            a.sort_unstable();
            b.sort_unstable();
            let near = |x: &[i64; 3], y: &[i64; 3]| (0..3).all(|c| (x[c] - y[c]).abs() <= 2);
            assert!(a.iter().all(|x| b.iter().any(|y| near(x, y))));
        }
    }
}
