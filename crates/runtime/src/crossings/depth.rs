//! The shortest translation that separates two triangles.

use super::exact::Point;
use crate::number::real::{cross, dot, sub};

/// The length \[m\] of the shortest translation of one of two triangles after which their interiors share no point; 0 for triangles in one plane
/// and triangles that do not meet. By separating axes: the normals of both and the cross products of their edges. In f64, with rounding.
pub fn depth(a: &[Point; 3], b: &[Point; 3]) -> f64 {
    // Differences of coordinates round less than products of coordinates far from the origin.
    let origin = a[0];
    let [a, b] = [a, b].map(|t| t.map(|p| sub(p, origin)));
    let edges = |t: &[Point; 3]| [0, 1, 2].map(|k| sub(t[(k + 1) % 3], t[k]));
    let (of_a, of_b) = (edges(&a), edges(&b));
    let mut least = f64::INFINITY;
    let mut along = |axis: Point, scale: f64| {
        let length = dot(axis, axis).sqrt();
        // Edges that are parallel to rounding give no direction.
        if length > 1e-12 * scale {
            let ([low_a, high_a], [low_b, high_b]) = (extent(&a, axis), extent(&b, axis));
            least = least.min(f64::min(high_a - low_b, high_b - low_a).max(0.0) / length);
        }
    };
    for [first, second, _] in [of_a, of_b] {
        along(cross(first, second), 0.0);
    }
    for p in of_a {
        for q in of_b {
            along(cross(p, q), (dot(p, p) * dot(q, q)).sqrt());
        }
    }
    if least.is_finite() { least } else { 0.0 }
}

/// The least and the largest coordinate along an axis of any length.
fn extent(t: &[Point; 3], axis: Point) -> [f64; 2] {
    let along = t.map(|p| dot(p, axis));
    [along.iter().copied().fold(f64::INFINITY, f64::min), along.iter().copied().fold(f64::NEG_INFINITY, f64::max)]
}
