//! Whether a point is inside a body, which may have holes, several parts and parts within parts.

use crate::base::mesh::Mesh;
use crate::base::vec3::{cross, dot, norm, sub};

/// Tangent of the half angle below which a triangle is far away, as nearly all are.
const FAR: f64 = 0.125;

/// The arc tangent of a number below [`FAR`], to 1e-11.
fn small_angle(x: f64) -> f64 {
    let s = x * x;
    x * (1.0 - s * (1.0 / 3.0 - s * (0.2 - s * (1.0 / 7.0 - s / 9.0))))
}

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
            let volume = dot(a, cross(b, c));
            if volume.abs() < FAR * across { small_angle(volume / across) } else { volume.atan2(across) }
        };
        self.corners.iter().map(angle).sum::<f64>() / (2.0 * std::f64::consts::PI)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn small_angles_are_those_of_the_arc_tangent() {
        for k in -1000..=1000 {
            let x = FAR * f64::from(k) / 1000.0;
            assert!((small_angle(x) - x.atan()).abs() < 1.1e-11, "{x}");
        }
    }
}
