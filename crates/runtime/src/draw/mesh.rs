//! Meshes of colliders, in their own frames.

use std::f32::consts::{PI, TAU};

use crate::collider::Shape;
use crate::number::real::{dot, scale};

/// A vertex: position and normal; their fourth components are texture coordinates.
pub type Vertex = [[f32; 4]; 2];

/// Half the side of the square \[m\] that stands for a plane, and where it has faded.
pub const FLOOR_RADIUS: f32 = 6.0;
/// Quads around a round shape, twice those from pole to pole.
const AROUND: usize = 64;

/// Triangles of a shape, counter-clockwise outside, three vertices each. The surface is drawn `inset` \[m\] within the
/// shape, because cloth on it has chords that dip below.
pub fn of(shape: &Shape, inset: f32) -> Vec<Vertex> {
    let mut mesh = match *shape {
        Shape::HalfSpace => floor(),
        Shape::Sphere { radius } => round(|n| scale(n, radius), |n| n),
        Shape::Capsule { half_height, radius } => {
            // The equator's ring, which has no height, goes with the lower half; the quads above it make the cylinder.
            let half = |y: f32| if y > 1e-6 { half_height } else { -half_height };
            round(move |n| [radius * n[0], radius * n[1] + half(n[1]), radius * n[2]], |n| n)
        }
        Shape::TaperedCapsule { half_height, radii: [low, high] } => {
            // The balls part where the normal of the cone points; the quads there make the cone.
            let along = (low - high) / (2.0 * half_height);
            let of = move |y: f32| if y > along + 1e-6 { (half_height, high) } else { (-half_height, low) };
            let on = move |n: [f32; 3]| {
                let (y, radius) = of(n[1]);
                [radius * n[0], radius * n[1] + y, radius * n[2]]
            };
            round(on, |n| n)
        }
        // Vertices on an edge have one normal of several, so its faces are moved by its sides.
        Shape::Box { half } => return cuboid(half.map(|h| (h - inset).max(0.0))),
        Shape::Ellipsoid { radii, .. } => {
            let on = move |n: [f32; 3]| [0, 1, 2].map(|c| n[c] * radii[c]);
            round(on, move |n| unit([0, 1, 2].map(|c| n[c] / radii[c])))
        }
    };
    for [at, normal] in &mut mesh {
        (0..3).for_each(|c| at[c] -= normal[c] * inset);
    }
    mesh
}

fn unit(v: [f32; 3]) -> [f32; 3] {
    scale(v, 1.0 / dot(v, v).sqrt().max(f32::MIN_POSITIVE))
}

/// From unit vectors to points and normals.
fn round(at: impl Fn([f32; 3]) -> [f32; 3], normal: impl Fn([f32; 3]) -> [f32; 3]) -> Vec<Vertex> {
    let rows = AROUND / 2;
    let vertex = |i: usize, j: usize| {
        let (a, b) = (TAU * (i % AROUND) as f32 / AROUND as f32, PI * j as f32 / rows as f32);
        let n = [b.sin() * a.cos(), b.cos(), b.sin() * a.sin()];
        let (p, n) = (at(n), normal(n));
        [[p[0], p[1], p[2], 0.0], [n[0], n[1], n[2], 0.0]]
    };
    let mut mesh = Vec::with_capacity(AROUND * rows * 6);
    for (i, j) in (0..rows).flat_map(|j| (0..AROUND).map(move |i| (i, j))) {
        let [a, b, c, d] = [vertex(i, j), vertex(i + 1, j), vertex(i + 1, j + 1), vertex(i, j + 1)];
        mesh.extend([a, b, c, a, c, d]);
    }
    mesh
}

fn cuboid(half: [f32; 3]) -> Vec<Vertex> {
    let mut mesh = Vec::with_capacity(36);
    for (axis, way) in (0..3).flat_map(|a| [(a, 1.0), (a, -1.0)]) {
        let (u, v) = ((axis + 1) % 3, (axis + 2) % 3);
        let corner = |s: f32, t: f32| {
            let (mut p, mut n) = ([0.0; 4], [0.0; 4]);
            (p[axis], p[u], p[v]) = (half[axis] * way, half[u] * s * way, half[v] * t);
            n[axis] = way;
            [p, n]
        };
        let [a, b, c, d] = [corner(-1.0, -1.0), corner(1.0, -1.0), corner(1.0, 1.0), corner(-1.0, 1.0)];
        mesh.extend([a, b, c, a, c, d]);
    }
    mesh
}

fn floor() -> Vec<Vertex> {
    let r = FLOOR_RADIUS;
    let corner = |x: f32, z: f32| [[x, 0.0, z, x], [0.0, 1.0, 0.0, z]];
    let [a, b, c, d] = [corner(-r, -r), corner(-r, r), corner(r, r), corner(r, -r)];
    vec![a, b, c, a, c, d]
}

/// Half the extent \[m\] of a shape along each axis of its frame; `None` for a half-space, which has none.
pub fn half_extent(shape: &Shape) -> Option<[f32; 3]> {
    match *shape {
        Shape::HalfSpace => None,
        Shape::Sphere { radius } => Some([radius; 3]),
        Shape::Capsule { half_height, radius } => Some([radius, radius + half_height, radius]),
        Shape::TaperedCapsule { half_height, radii: [low, high] } => {
            let radius = low.max(high);
            Some([radius, radius + half_height, radius])
        }
        Shape::Box { half } => Some(half),
        Shape::Ellipsoid { radii, .. } => Some(radii),
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::number::real::{cross, sub, xyz};

    /// Twice the area of a triangle, as a vector out of its front.
    fn face(t: &[Vertex]) -> [f32; 3] {
        let at = |v: &Vertex| xyz(v[0]);
        cross(sub(at(&t[1]), at(&t[0])), sub(at(&t[2]), at(&t[0])))
    }

    #[test]
    fn meshes_face_outwards_and_have_the_shapes_size() {
        for shape in [
            Shape::HalfSpace,
            Shape::Sphere { radius: 0.3 },
            Shape::Capsule { half_height: 0.4, radius: 0.1 },
            Shape::TaperedCapsule { half_height: 0.3, radii: [0.05, 0.1] },
            Shape::Box { half: [0.1, 0.2, 0.3] },
            Shape::Ellipsoid { radii: [0.1, 0.3, 0.2], closest: true },
        ] {
            let mesh = of(&shape, 0.0);
            assert_eq!(mesh.len() % 3, 0);
            for t in mesh.chunks(3) {
                let n = [t[0][1][0], t[0][1][1], t[0][1][2]];
                assert!(dot(face(t), n) >= -1e-9, "{shape:?}: {t:?}");
                assert!((dot(n, n) - 1.0).abs() < 1e-5);
            }
            let Some(half) = half_extent(&shape) else { continue };
            for c in 0..3 {
                let far = mesh.iter().map(|v| v[0][c].abs()).fold(0.0, f32::max);
                assert!((far - half[c]).abs() < 1e-6, "{shape:?}");
            }
            let nearer = of(&shape, 0.01).iter().map(|v| v[0][1]).fold(0.0, f32::max);
            assert!((nearer - (half[1] - 0.01)).abs() < 1e-6, "{shape:?}");
        }
    }
}
