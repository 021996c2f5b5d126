//! Whether a point is inside a body, which may have holes, several parts and parts within parts.

use crate::base::mesh::Mesh;
use crate::base::vec3::{cross, dot, norm, sub};

/// The triangles of a body.
pub(super) struct Winding {
    corners: Vec<[[f64; 3]; 3]>,
}

impl Winding {
    pub fn new(mesh: &Mesh) -> Self {
        Winding { corners: (0..mesh.triangles.len()).map(|t| mesh.corners(t)).collect() }
    }

    /// The generalised winding number (Jacobson, Kavan and Sorkine-Hornung 2013): 1 inside a closed surface, 0 outside, between them
    /// near holes. O(triangles).
    pub fn number(&self, p: [f64; 3]) -> f64 {
        let angle = |corners: &[[f64; 3]; 3]| {
            let [a, b, c] = corners.map(|x| sub(x, p));
            let (la, lb, lc) = (norm(a), norm(b), norm(c));
            let across = la * lb * lc + dot(a, b) * lc + dot(b, c) * la + dot(c, a) * lb;
            // Van Oosterom and Strackee 1983; its half angle.
            dot(a, cross(b, c)).atan2(across)
        };
        self.corners.iter().map(angle).sum::<f64>() / (2.0 * std::f64::consts::PI)
    }
}
