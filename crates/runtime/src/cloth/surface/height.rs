//! How high points are above a surface at rest.

use super::{BodySurface, On, normal, on_triangle};
use crate::number::real::{V3, add, cast, dot, scale, sub};

/// The heights \[m\] of points, below 0 inside. O(log n) per point.
pub fn heights(surface: &BodySurface, points: impl Iterator<Item = [f32; 3]>) -> Vec<f32> {
    let corners = |t: u32| -> [V3<f64>; 3] { surface.triangles[t as usize].map(|v| cast(surface.rest[v as usize])) };
    let mut bounds = Vec::new();
    surface.tree.fit(corners, &mut bounds);
    let height = |p: [f32; 3]| {
        let p: V3<f64> = cast(p);
        let (t, _) = surface.tree.nearest(&bounds, p, |t| on_triangle(p, t, corners(t)).distance2);
        let (own, spot) = (corners(t), on_triangle(p, t, corners(t)));
        let mix = |list: [V3<f64>; 3]| (0..3).fold([0.0; 3], |sum, k| add(sum, scale(list[k], spot.weights[k])));
        let smooth = || mix(surface.triangles[t as usize].map(|v| cast(surface.normals[v as usize])));
        let up = if spot.on == On::Face { normal(own) } else { smooth() };
        let far = spot.distance2.sqrt();
        (if dot(sub(p, mix(own)), up) < 0.0 { -far } else { far }) as f32
    };
    points.map(height).collect()
}
