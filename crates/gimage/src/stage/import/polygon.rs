//! A polygon in space to triangles, by clipping ears in its best-fit plane.
//!
//! A convex polygon becomes a fan from its first corner. Polygons that cross themselves, or have no area, still become n - 2
//! triangles: they are told apart by [`Quality`], and a later stage drops what has no area.

use crate::base::vec3::{add, cross, dot, norm, normalize, scale, sub};

/// How a polygon went.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) enum Quality {
    /// The triangles cover the polygon, as seen along its normal, without overlap.
    Sound,
    /// The polygon has no area, crosses itself, or was too intricate; its triangles may overlap.
    Forced,
}

/// Steps after which an intricate polygon is cut anyhow.
const MAX_STEPS: usize = 20_000_000;

/// Triangles over the corners of a polygon, as indices of them, wound like the polygon.
pub(crate) fn triangulate(points: &[[f64; 3]]) -> (Vec<[usize; 3]>, Quality) {
    let n = points.len();
    let fan = || (1..n.saturating_sub(1)).map(|k| [0, k, k + 1]).collect::<Vec<_>>();
    if n <= 3 {
        return (fan(), Quality::Sound);
    }
    // Newell's normal; from the centroid, so that a polygon far from the origin keeps its digits.
    let center = scale(points.iter().copied().fold([0.0; 3], add), 1.0 / n as f64);
    let local: Vec<[f64; 3]> = points.iter().map(|&p| sub(p, center)).collect();
    let normal = (0..n).map(|i| cross(local[i], local[(i + 1) % n])).fold([0.0; 3], add);
    let size = local.iter().map(|&p| norm(p)).fold(0.0, f64::max);
    if norm(normal) <= 1e-12 * size * size {
        return (fan(), Quality::Forced);
    }
    let flat = project(&local, normalize(normal), size);
    if is_convex(&flat) {
        return (fan(), Quality::Sound);
    }
    clip(&flat)
}

/// The polygon in its plane, scaled to unit size, counter-clockwise.
fn project(points: &[[f64; 3]], normal: [f64; 3], size: f64) -> Vec<[f64; 2]> {
    let k = (0..3).min_by(|&a, &b| normal[a].abs().total_cmp(&normal[b].abs())).unwrap_or(0);
    let axis = std::array::from_fn(|i| f64::from(u8::from(i == k)));
    let u = normalize(cross(axis, normal));
    let v = cross(normal, u);
    points.iter().map(|&p| [dot(p, u) / size, dot(p, v) / size]).collect()
}

/// Twice the signed area of a triangle.
fn turn(a: [f64; 2], b: [f64; 2], c: [f64; 2]) -> f64 {
    (b[0] - a[0]) * (c[1] - a[1]) - (b[1] - a[1]) * (c[0] - a[0])
}

/// Whether a fan from the first corner covers the polygon: it turns left everywhere, and only once around.
fn is_convex(p: &[[f64; 2]]) -> bool {
    let n = p.len();
    (0..n).all(|i| turn(p[i], p[(i + 1) % n], p[(i + 2) % n]) >= 0.0)
        && (1..n - 1).all(|k| turn(p[0], p[k], p[k + 1]) >= 0.0)
}

fn clip(p: &[[f64; 2]]) -> (Vec<[usize; 3]>, Quality) {
    let n = p.len();
    let mut out = Vec::with_capacity(n - 2);
    let mut quality = Quality::Sound;
    let mut ring: Vec<usize> = (0..n).collect();
    let (mut at, mut steps) = (0, 0);
    while ring.len() > 3 {
        let m = ring.len();
        let corner = |i: usize| [ring[(i + m - 1) % m], ring[i % m], ring[(i + 1) % m]];
        let area = |i: usize| {
            let [a, b, c] = corner(i);
            turn(p[a], p[b], p[c])
        };
        let mut is_ear = |i: usize| {
            let t = corner(i);
            if steps >= MAX_STEPS || area(i) <= 0.0 {
                return false;
            }
            steps += m;
            !ring.iter().any(|&v| !t.contains(&v) && blocks(p, t, v))
        };
        let ear = (at..at + m).map(|i| i % m).find(|&i| is_ear(i)).or_else(|| {
            // Nothing sticks out: a corner on a straight line goes first, which costs nothing.
            (at..at + m).map(|i| i % m).find(|&i| area(i) == 0.0)
        });
        let ear = ear.unwrap_or_else(|| {
            quality = Quality::Forced;
            (0..m).max_by(|&i, &j| area(i).total_cmp(&area(j)).then(j.cmp(&i))).unwrap_or(0)
        });
        out.push(corner(ear));
        ring.remove(ear);
        // Going on behind the clipped corner spreads the triangles instead of fanning them.
        at = ear % ring.len();
    }
    out.push([ring[0], ring[1], ring[2]]);
    if turn(p[ring[0]], p[ring[1]], p[ring[2]]) < 0.0 {
        quality = Quality::Forced;
    }
    (out, quality)
}

/// Whether corner `v` lies in or on triangle `t`. Corners that repeat a point of the triangle (where a slit leads to a hole)
/// are not obstacles.
fn blocks(p: &[[f64; 2]], t: [usize; 3], v: usize) -> bool {
    let q = p[v];
    if t.iter().any(|&c| p[c] == q) {
        return false;
    }
    turn(p[t[0]], p[t[1]], q) >= 0.0 && turn(p[t[1]], p[t[2]], q) >= 0.0 && turn(p[t[2]], p[t[0]], q) >= 0.0
}

#[cfg(test)]
mod tests {
    use super::*;
    use proptest::prelude::*;

    fn normal_of(points: &[[f64; 3]], t: [usize; 3]) -> [f64; 3] {
        let [a, b, c] = t.map(|k| points[k]);
        scale(cross(sub(b, a), sub(c, a)), 0.5)
    }

    #[test]
    fn a_concave_quad_is_split_at_its_reflex_corner() {
        let quad = [[2.0, 0.0, 0.0], [0.5, 0.5, 0.0], [0.0, 2.0, 0.0], [0.0, 0.0, 0.0]];
        for start in 0..4 {
            let mut turned = quad;
            turned.rotate_left(start);
            let (triangles, quality) = triangulate(&turned);
            assert_eq!(quality, Quality::Sound);
            let areas: Vec<f64> = triangles.iter().map(|&t| normal_of(&turned, t)[2]).collect();
            assert!(areas.iter().all(|&a| a > 0.0), "{areas:?}");
            assert!((areas.iter().sum::<f64>() - 1.0).abs() < 1e-12);
        }
    }

    #[test]
    fn a_polygon_with_a_slit_to_its_hole_is_covered() {
        let xy = [
            [0.0, 0.0],
            [4.0, 0.0],
            [4.0, 4.0],
            [0.0, 4.0],
            [0.0, 0.0],
            [1.0, 1.0],
            [1.0, 3.0],
            [3.0, 3.0],
            [3.0, 1.0],
            [1.0, 1.0],
        ];
        let points: Vec<[f64; 3]> = xy.iter().map(|p| [p[0], p[1], 0.0]).collect();
        let (triangles, quality) = triangulate(&points);
        assert_eq!((triangles.len(), quality), (8, Quality::Sound));
        let areas: Vec<f64> = triangles.iter().map(|&t| normal_of(&points, t)[2]).collect();
        assert!(areas.iter().all(|&a| a >= 0.0) && (areas.iter().sum::<f64>() - 12.0).abs() < 1e-12, "{areas:?}");
    }

    #[test]
    fn what_has_no_area_or_crosses_itself_is_told() {
        let line = [[0.0; 3], [1.0, 0.0, 0.0], [2.0, 0.0, 0.0], [3.0, 0.0, 0.0]];
        assert_eq!(triangulate(&line).1, Quality::Forced);
        assert_eq!(triangulate(&[[1.0; 3]; 5]).0.len(), 3);
        let star: Vec<[f64; 3]> =
            (0..5).map(|k| (k as f64 * 144f64.to_radians()).sin_cos()).map(|(s, c)| [c, s, 0.0]).collect();
        assert_eq!(triangulate(&star), (triangulate(&star).0, Quality::Forced));
    }

    #[test]
    fn a_comb_of_many_corners_ends_soon() {
        let comb: Vec<[f64; 3]> = (0..1500)
            .map(|k| [k as f64, if k % 2 == 0 { 0.0 } else { 50.0 }, 0.0])
            .chain([[1500.0, -1.0, 0.0], [0.0, -1.0, 0.0]])
            .rev()
            .collect();
        let (triangles, _) = triangulate(&comb);
        assert_eq!(triangles.len(), comb.len() - 2);
    }

    proptest! {
        /// A star-shaped polygon in any plane, anywhere: its triangles add up to its area and none is turned over.
        #[test]
        fn star_shaped_polygons_are_covered(
            radii in prop::collection::vec(0.2f64..1.0, 4..40),
            tilt in prop::array::uniform3(-1.0f64..1.0),
            shift in prop::array::uniform3(-10.0f64..10.0),
        ) {
            let w = normalize(add(tilt, [0.0, 0.0, 2.0]));
            let u = normalize(cross([0.0, 1.0, 0.0], w));
            let v = cross(w, u);
            let n = radii.len();
            let step = std::f64::consts::TAU / n as f64;
            let points: Vec<[f64; 3]> = (radii.iter().enumerate())
                .map(|(k, r)| (r, (k as f64 * step).sin_cos()))
                .map(|(r, (s, c))| add(shift, add(scale(u, r * c), scale(v, r * s))))
                .collect();
            let area: f64 = (0..n).map(|k| 0.5 * step.sin() * radii[k] * radii[(k + 1) % n]).sum();
            let (triangles, quality) = triangulate(&points);
            prop_assert_eq!(quality, Quality::Sound);
            prop_assert_eq!(triangles.len(), n - 2);
            let areas: Vec<f64> = triangles.iter().map(|&t| dot(normal_of(&points, t), w)).collect();
            prop_assert!(areas.iter().all(|&a| a > -1e-12), "{:?}", areas);
            prop_assert!((areas.iter().sum::<f64>() - area).abs() < 1e-9 * area);
        }
    }
}
