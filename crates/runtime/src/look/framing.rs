//! A camera that has given points just in its picture.

use super::camera::{Camera, MARGIN, axes};
use crate::number::real::{add, dot, scale};

/// Finds the camera nearest to points that has all of them in its picture. Its size does not depend on the number of points.
///
/// ```
/// use gimage_runtime::draw::Framing;
///
/// let mut framing = Framing::new([0.4, 0.3, 1.0], 0.6, 4.0 / 3.0);
/// framing.add([[0.0, 0.0, 0.0], [1.0, 2.0, 0.5]]);
/// assert!(framing.camera().is_some());
/// ```
#[derive(Clone, Debug)]
pub struct Framing {
    axes: [[f32; 3]; 3],
    fov: f32,
    /// Tangents of half of the angles of the picture: across and upwards.
    tan: [f32; 2],
    /// For each of these, and for each share of it in eighths, the largest numbers of all points: of p + t z and t z - p (p: across or upwards, z:
    /// towards the eye, t: the share of the tangent).
    sides: [[[f32; 2]; SHARES]; 2],
    /// Nearest to the eye, and farthest, as numbers towards it.
    depths: [f32; 2],
}

/// Shares of an angle for which it is known where points fit.
const SHARES: usize = 8;

/// The n-th of them, of the tangent of an angle.
fn share(tan: f32, n: usize) -> f32 {
    tan * (n + 1) as f32 / SHARES as f32
}

impl Framing {
    /// For a camera on the side that `from` points to, with a vertical field of view `fov` \[rad\], 0.01 to 3, and a picture of `aspect` = width /
    /// height.
    pub fn new(from: [f32; 3], fov: f32, aspect: f32) -> Self {
        let tan = (fov / 2.0).tan();
        let least = f32::NEG_INFINITY;
        Framing {
            axes: axes(from),
            fov,
            tan: [tan * aspect, tan],
            sides: [[[least; 2]; SHARES]; 2],
            depths: [least, -least],
        }
    }

    /// Takes in points \[m\]. Those that are not finite do not count.
    pub fn add(&mut self, points: impl IntoIterator<Item = [f32; 3]>) {
        let [right, up, back] = self.axes;
        for p in points.into_iter().filter(|p| p.iter().all(|x| x.is_finite())) {
            let z = dot(p, back);
            for ((sides, tan), axis) in self.sides.iter_mut().zip(self.tan).zip([right, up]) {
                let p = dot(p, axis);
                for (n, side) in sides.iter_mut().enumerate() {
                    let tan = share(tan, n);
                    *side = [side[0].max(p + tan * z), side[1].max(tan * z - p)];
                }
            }
            self.depths = [self.depths[0].max(z), self.depths[1].min(z)];
        }
    }

    /// The camera, with some room around the points; it looks at the middle of their depth. `None` without a point.
    pub fn camera(&self) -> Option<Camera> {
        let [right, up, back] = self.axes;
        let [near, far] = self.depths;
        if near < far {
            return None;
        }
        // Where all points are between two planes through the eye e, p + t z <= e_p + t e_z and t z - p <= t e_z - e_p: so far away it has to be.
        let reach = |c: usize, n: usize| {
            let [a, b] = self.sides[c][n];
            (a + b) / (2.0 * share(self.tan[c], n))
        };
        let away = [0, 1].map(|c| reach(c, SHARES - 1)).into_iter().fold(near, f32::max);
        // From there points may fit between nearer planes, which have them in their middle.
        let [x, y] = [0, 1].map(|c| {
            let n = (0..SHARES).find(|n| reach(c, *n) <= away).unwrap_or(SHARES - 1);
            let [a, b] = self.sides[c][n];
            (a - b) / 2.0
        });
        let middle = (near + far) / 2.0;
        let distance = (away - middle).max(1e-3) * MARGIN;
        let target = add(add(scale(right, x), scale(up, y)), scale(back, middle));
        Some(Camera { eye: add(target, scale(back, distance)), target, fov: self.fov })
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::look::View;

    fn project(view: &View, p: [f32; 3]) -> [f32; 2] {
        let clip = [0, 1, 2, 3].map(|r| (0..3).map(|c| view.clip[c][r] * p[c]).sum::<f32>() + view.clip[3][r]);
        assert!(clip[3] > 0.0 && (0.0..=clip[3]).contains(&clip[2]), "in front of the eye and between its planes");
        [clip[0] / clip[3], clip[1] / clip[3]]
    }

    #[test]
    fn points_fill_the_picture_one_way_and_are_in_its_middle() {
        // A staff: a box around it would be far larger than it is from this side.
        let staff = (0..50).map(|k| scale([0.7, 2.0, -1.3], k as f32 / 50.0)).collect::<Vec<_>>();
        let ball = (0..200).map(|k| (k as f32 * 0.7, k as f32 * 1.3));
        let ball = ball.map(|(a, b)| [3.0 + a.cos() * b.sin(), 1.0 + b.cos(), a.sin() * b.sin()]).collect::<Vec<_>>();
        for points in [staff, ball, vec![[5.0, 1.0, 2.0], [5.0, 1.0, 2.1]]] {
            for (fov, aspect) in [(0.6, 1.0), (0.6, 2.0), (1.5, 0.5)] {
                let mut framing = Framing::new([0.4, 0.3, 1.0], fov, aspect);
                framing.add(points.iter().copied());
                framing.add([[f32::NAN, 0.0, 0.0]]);
                let view = View::new(&framing.camera().unwrap(), aspect);
                let seen: Vec<_> = points.iter().map(|p| project(&view, *p)).collect();
                let ends = [0, 1].map(|c| {
                    let all = seen.iter().map(|p| p[c]);
                    [all.clone().fold(f32::INFINITY, f32::min), all.fold(f32::NEG_INFINITY, f32::max)]
                });
                // Two points one behind the other have no size.
                let fills = points.len() == 2 || ends.iter().any(|[low, high]| *low < -0.8 && *high > 0.8);
                assert!(fills, "{ends:?}");
                assert!(ends.iter().all(|[low, high]| *low > -1.0 && *high < 1.0), "{ends:?}");
                // From near, what is nearer is larger.
                assert!(
                    fov > 1.0 || points.len() == 2 || ends.iter().all(|[low, high]| (low + high).abs() < 0.35),
                    "{ends:?}"
                );
            }
        }
    }

    #[test]
    fn no_points_have_no_camera() {
        let mut framing = Framing::new([0.4, 0.3, 1.0], 0.6, 1.0);
        assert_eq!(framing.camera(), None);
        framing.add([[0.0; 3]]);
        assert!(framing.camera().is_some_and(|camera| camera.check().is_ok()));
    }
}
