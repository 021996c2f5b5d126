//! Whether a point is inside of triangles that may have holes, several parts and parts within parts.

/// Tangent of the half angle below which a triangle is far away, as nearly all are.
const FAR: f64 = 0.125;

type V3 = [f64; 3];

/// Triangles, and how often they wind around a point.
#[derive(Clone, Debug)]
pub struct Winding {
    corners: Vec<[V3; 3]>,
}

impl Winding {
    /// That of triangles given by their corners, counter-clockwise as seen from outside.
    pub fn new(corners: impl Iterator<Item = [[f64; 3]; 3]>) -> Self {
        Winding { corners: corners.collect() }
    }

    /// The generalised winding number (Jacobson, Kavan and Sorkine-Hornung 2013): 1 inside a closed surface, 0 outside, between them
    /// near holes. O(triangles).
    pub fn number(&self, p: [f64; 3]) -> f64 {
        let angle = |corners: &[V3; 3]| {
            let [a, b, c] = corners.map(|x| [x[0] - p[0], x[1] - p[1], x[2] - p[2]]);
            let (la, lb, lc) = (dot(a, a).sqrt(), dot(b, b).sqrt(), dot(c, c).sqrt());
            let across = la * lb * lc + dot(a, b) * lc + dot(b, c) * la + dot(c, a) * lb;
            // Van Oosterom and Strackee 1983; its half angle.
            let volume = dot(a, cross(b, c));
            if volume.abs() < FAR * across { small_angle(volume / across) } else { volume.atan2(across) }
        };
        self.corners.iter().map(angle).sum::<f64>() / (2.0 * std::f64::consts::PI)
    }
}

/// The arc tangent of a number below [`FAR`], to 1e-11.
fn small_angle(x: f64) -> f64 {
    let s = x * x;
    x * (1.0 - s * (1.0 / 3.0 - s * (0.2 - s * (1.0 / 7.0 - s / 9.0))))
}

fn dot(a: V3, b: V3) -> f64 {
    a[0] * b[0] + a[1] * b[1] + a[2] * b[2]
}

fn cross(a: V3, b: V3) -> V3 {
    [a[1] * b[2] - a[2] * b[1], a[2] * b[0] - a[0] * b[2], a[0] * b[1] - a[1] * b[0]]
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

    #[test]
    fn a_tetrahedron_winds_once_around_its_middle_and_not_around_points_outside() {
        let at = [[0.0, 0.0, 0.0], [1.0, 0.0, 0.0], [0.0, 1.0, 0.0], [0.0, 0.0, 1.0]];
        let faces = [[0, 2, 1], [0, 1, 3], [0, 3, 2], [1, 2, 3]];
        let winding = Winding::new(faces.into_iter().map(|f: [usize; 3]| f.map(|v| at[v])));
        assert!((winding.number([0.2, 0.2, 0.2]) - 1.0).abs() < 1e-9);
        assert!(winding.number([0.5, 0.5, 0.5]).abs() < 1e-9);
        assert!(winding.number([-3.0, 7.0, 1.0]).abs() < 1e-9);
    }
}
