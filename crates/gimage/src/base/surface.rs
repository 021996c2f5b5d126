//! One connected component, with the indices of its triangles in the mesh.

/// A connected, edge-manifold surface without bow ties.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Surface {
    /// Vertex positions \[m\], every one used.
    pub positions: Vec<[f64; 3]>,
    /// Vertex indices.
    pub triangles: Vec<[u32; 3]>,
    /// For each triangle, its index in the mesh.
    pub source_triangle: Vec<u32>,
    /// For each triangle, which corner of it in the mesh, 0..=2, its first is; the others follow in the same order.
    pub first_corner: Vec<u8>,
}

impl Surface {
    /// The corner positions of triangle `t` \[m\].
    pub fn corners(&self, t: usize) -> [[f64; 3]; 3] {
        self.triangles[t].map(|v| self.positions[v as usize])
    }

    /// The corner of the mesh's triangle that corner `c` of triangle `t` is.
    pub fn source_corner(&self, t: usize, c: usize) -> usize {
        (usize::from(self.first_corner[t]) + c) % 3
    }

    /// Area of triangle `t` \[m2\].
    pub fn triangle_area(&self, t: usize) -> f64 {
        use crate::base::vec3::{cross, norm, sub};
        let [a, b, c] = self.corners(t);
        0.5 * norm(cross(sub(b, a), sub(c, a)))
    }

    /// Area of the whole \[m2\].
    pub fn area(&self) -> f64 {
        (0..self.triangles.len()).map(|t| self.triangle_area(t)).sum()
    }
}
