//! The frame of the drawn surface at a point.

/// Right-angled unit axes at a point of the drawn surface, in the space of the cloth.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Frame {
    /// Along u, across the normal.
    pub tangent: [f32; 3],
    /// The cross product of normal and tangent.
    pub bitangent: [f32; 3],
    /// The normal, interpolated between the corners of the triangle.
    pub normal: [f32; 3],
}

/// The square of the length below which an interpolated normal has no direction, as a share of 1.
const NO_NORMAL: f32 = 1e-6;
/// The share of the square of an edge that has to be across the normal, so that the edge gives a direction.
const ALONG: f32 = 1e-6;

impl Frame {
    /// The frame of a triangle, given the positions \[m\] and unit normals of its corners and the weights of the second and the third, as in
    /// [`crate::SurfacePoint`]. shaders/wrap.wgsl has the same operations in the same order.
    ///
    /// Normals that cancel out give way to the normal of the triangle, and an edge along the normal to the next edge; a triangle that is a
    /// point has the axes of the space. Never NaN for finite numbers of a usual size.
    pub fn new(corners: [[f32; 3]; 3], normals: [[f32; 3]; 3], weights: [f32; 2]) -> Frame {
        let [first, second] = edges(corners);
        let [a, b, c] = normals;
        let sum: [f32; 3] = std::array::from_fn(|k| a[k] + (b[k] - a[k]) * weights[0] + (c[k] - a[k]) * weights[1]);
        let normal = if dot(sum, sum) > NO_NORMAL { unit(sum) } else { unit(cross(second, first)) };
        let normal = if dot(normal, normal) > 0.0 { normal } else { [0.0, 0.0, 1.0] };
        let across = |edge: [f32; 3]| {
            let along = dot(edge, normal);
            let rest: [f32; 3] = std::array::from_fn(|k| edge[k] - normal[k] * along);
            (dot(rest, rest) > ALONG * dot(edge, edge)).then_some(rest)
        };
        // The axis of the space that is the least along the normal is never along it.
        let axis = || {
            let size = normal.map(f32::abs);
            if size[0] <= size[1] && size[0] <= size[2] {
                [1.0, 0.0, 0.0]
            } else if size[1] <= size[2] {
                [0.0, 1.0, 0.0]
            } else {
                [0.0, 0.0, 1.0]
            }
        };
        let edge = across(first).or_else(|| across(second)).or_else(|| across(axis()));
        let tangent = unit(edge.unwrap_or([1.0, 0.0, 0.0]));
        Frame { tangent, bitangent: cross(normal, tangent), normal }
    }

    /// A vector of the space, given its components along the axes.
    pub fn outward(&self, [x, y, z]: [f32; 3]) -> [f32; 3] {
        std::array::from_fn(|k| self.tangent[k] * x + self.bitangent[k] * y + self.normal[k] * z)
    }

    /// The components of a vector of the space along the axes.
    pub fn inward(&self, v: [f64; 3]) -> [f64; 3] {
        [self.tangent, self.bitangent, self.normal].map(|axis| (0..3).map(|k| f64::from(axis[k]) * v[k]).sum())
    }

    /// The place of a bound vertex \[m\]: the point of the triangle, and `offset` \[m\] along the axes. Rounded once at the size of a
    /// position.
    pub fn place(&self, corners: [[f32; 3]; 3], weights: [f32; 2], offset: [f32; 3]) -> [f32; 3] {
        let ([first, second], by) = (edges(corners), self.outward(offset));
        std::array::from_fn(|k| corners[0][k] + (first[k] * weights[0] + second[k] * weights[1] + by[k]))
    }
}

fn edges([a, b, c]: [[f32; 3]; 3]) -> [[f32; 3]; 2] {
    [b, c].map(|p| std::array::from_fn(|k| p[k] - a[k]))
}

fn dot(a: [f32; 3], b: [f32; 3]) -> f32 {
    a[0] * b[0] + a[1] * b[1] + a[2] * b[2]
}

fn cross(a: [f32; 3], b: [f32; 3]) -> [f32; 3] {
    [a[1] * b[2] - a[2] * b[1], a[2] * b[0] - a[0] * b[2], a[0] * b[1] - a[1] * b[0]]
}

/// The direction of a vector; 0 if it has none.
fn unit(v: [f32; 3]) -> [f32; 3] {
    let length = dot(v, v).sqrt();
    if length > 0.0 { v.map(|x| x * (1.0 / length)) } else { [0.0; 3] }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn axes_are_at_right_angles_whatever_the_triangle() {
        let up = [[0.0, 0.0, 1.0]; 3];
        let flat = [[0.0; 3], [0.1, 0.0, 0.0], [0.0, -0.1, 0.0]];
        let cases = [
            (flat, up),
            (flat, [[0.6, 0.0, 0.8], [0.0, 0.6, 0.8], [0.0, 0.0, 1.0]]),
            // Normals that cancel, an edge along the normal, a point.
            (flat, [[0.0, 0.0, 1.0], [0.0, 0.0, -1.0], [0.0; 3]]),
            ([[0.0; 3], [0.0, 0.0, 0.1], [0.1, 0.0, 0.0]], up),
            ([[0.3; 3]; 3], up),
            ([[0.3; 3]; 3], [[0.0; 3]; 3]),
        ];
        for (corners, normals) in cases {
            let frame = Frame::new(corners, normals, [0.5, 0.25]);
            let axes = [frame.tangent, frame.bitangent, frame.normal];
            for (i, a) in axes.iter().enumerate() {
                for (j, b) in axes.iter().enumerate() {
                    let want = if i == j { 1.0 } else { 0.0 };
                    assert!((dot(*a, *b) - want).abs() < 1e-6, "{frame:?}");
                }
            }
            let back = frame.outward(frame.inward([0.1, -0.2, 0.3]).map(|x| x as f32));
            assert!(back.iter().zip([0.1, -0.2, 0.3]).all(|(a, b)| (a - b).abs() < 1e-6));
        }
    }

    #[test]
    fn a_vertex_turns_with_its_triangle() {
        let turn = |[x, y, z]: [f32; 3]| [x, -z, y];
        let corners = [[1.0, 2.0, 3.0], [1.1, 2.0, 3.0], [1.0, 2.1, 3.02]];
        let normals = [[0.0, 0.0, 1.0], [0.28, 0.0, 0.96], [0.0, 0.0, 1.0]];
        let (weights, offset) = ([0.25, 0.5], [0.01, -0.02, 0.03]);
        let place = |c: [[f32; 3]; 3], n: [[f32; 3]; 3]| Frame::new(c, n, weights).place(c, weights, offset);
        let (want, got) = (turn(place(corners, normals)), place(corners.map(turn), normals.map(turn)));
        assert!(want.iter().zip(got).all(|(a, b)| (a - b).abs() < 1e-6), "{want:?} {got:?}");
    }
}
