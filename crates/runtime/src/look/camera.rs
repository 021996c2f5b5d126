//! Where pictures are taken from.

use crate::error::{Result, check};
use crate::number::real::{add, cross, dot, scale, sub};

/// A camera that keeps +y up.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Camera {
    /// Its position \[m\].
    pub eye: [f32; 3],
    /// The point that it looks at \[m\]; not its position, nor straight above or below it.
    pub target: [f32; 3],
    /// Vertical field of view \[rad\], 0.01 to 3.
    pub fov: f32,
}

/// Room left around what is framed, as a share of its distance.
pub(super) const MARGIN: f32 = 1.06;

impl Camera {
    /// Refuses values that do not give a picture.
    pub fn check(&self) -> Result<()> {
        for x in [self.eye, self.target].as_flattened() {
            check("the place of the camera [m]", f64::from(*x), "finite", |_| true)?;
        }
        check("the angle of the camera [rad]", f64::from(self.fov), "0.01 to 3", |f| (0.01..=3.0).contains(&f))?;
        let d = sub(self.target, self.eye).map(f64::from);
        let (far, side) = (d.iter().map(|x| x * x).sum::<f64>().sqrt(), d[0].hypot(d[2]));
        check("the distance from camera to target [m]", far, "above 0", |d| d > 0.0)?;
        check("the sine of the camera's angle to the vertical", side / far, "above 0", |s| s > 1e-6)
    }

    /// A camera that has the box from `low` to `high` \[m\] just in its picture of `aspect` = width / height, and looks
    /// at its middle from the side that `from` points to.
    pub fn framing(low: [f32; 3], high: [f32; 3], from: [f32; 3], fov: f32, aspect: f32) -> Self {
        let target = scale(add(low, high), 0.5);
        let [right, up, back] = axes(from);
        let (tan_y, tan_x) = ((fov / 2.0).tan(), (fov / 2.0).tan() * aspect);
        let corner = |k: usize| [0, 1, 2].map(|c| if k >> c & 1 == 1 { high[c] } else { low[c] } - target[c]);
        let need = |k: usize| {
            let p = corner(k);
            dot(p, back) + (dot(p, right).abs() / tan_x).max(dot(p, up).abs() / tan_y)
        };
        let far = (0..8).map(need).fold(1e-3, f32::max) * MARGIN;
        Camera { eye: add(target, scale(back, far)), target, fov }
    }
}

/// The view of a picture: the matrix of a camera, or of the host.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct View {
    /// From the world to clip space, column by column; x right, y up, depth 0 to 1 (or 1 to 0, see `Target`).
    pub clip: [[f32; 4]; 4],
    /// Where the eye is \[m\].
    pub eye: [f32; 3],
    /// The point that it looks at \[m\]; floors fade away from here.
    pub target: [f32; 3],
    /// The colour that floors fade into: sRGB, 0 to 1.
    pub background: [f32; 3],
}

impl View {
    /// View of a camera in a picture of `aspect` = width / height, from 1/50 of the distance to its target up to 200
    /// times as far, on a white background.
    pub fn new(camera: &Camera, aspect: f32) -> Self {
        let Camera { eye, target, fov } = *camera;
        let d = sub(eye, target);
        let [right, up, back] = axes(d);
        let far = dot(d, d).sqrt();
        let (near, far) = (far * 0.02, far * 200.0);
        let y = 1.0 / (fov / 2.0).tan();
        let x = y / aspect;
        let (a, b) = (far / (near - far), near * far / (near - far));
        let column = |c: usize| [x * right[c], y * up[c], a * back[c], -back[c]];
        let moved = |axis: [f32; 3]| -dot(axis, eye);
        let last = [x * moved(right), y * moved(up), a * moved(back) + b, -moved(back)];
        let clip = [column(0), column(1), column(2), last];
        View { clip, eye, target, background: [1.0; 3] }
    }

    /// Right, up and back of the eye.
    pub(crate) fn axes(&self) -> [[f32; 3]; 3] {
        axes(sub(self.eye, self.target))
    }
}

/// Right, up and back of an eye that looks from the side that `back` points to.
pub(super) fn axes(back: [f32; 3]) -> [[f32; 3]; 3] {
    let unit = |v: [f32; 3]| scale(v, 1.0 / dot(v, v).sqrt().max(f32::MIN_POSITIVE));
    let back = unit(back);
    let right = cross([0.0, 1.0, 0.0], back);
    // Straight above or below any right will do.
    let right = if dot(right, right) > 1e-12 { unit(right) } else { [1.0, 0.0, 0.0] };
    [right, cross(back, right), back]
}

#[cfg(test)]
mod tests {
    use super::*;

    fn project(view: &View, p: [f32; 3]) -> [f32; 3] {
        let clip = [0, 1, 2, 3].map(|r| (0..3).map(|c| view.clip[c][r] * p[c]).sum::<f32>() + view.clip[3][r]);
        [clip[0] / clip[3], clip[1] / clip[3], clip[2] / clip[3]]
    }

    #[test]
    fn the_target_is_in_the_middle_and_up_is_up() {
        let camera = Camera { eye: [1.0, 2.0, 3.0], target: [0.5, 0.5, 0.0], fov: 1.0 };
        camera.check().unwrap();
        let view = View::new(&camera, 1.5);
        let [x, y, z] = project(&view, camera.target);
        assert!(x.abs() < 1e-5 && y.abs() < 1e-5 && (0.9..1.0).contains(&z), "{x} {y} {z}");
        assert!(project(&view, [0.5, 0.6, 0.0])[1] > 0.01);
        assert!(project(&view, [0.8, 0.5, -0.1])[0] > 0.01);
    }

    #[test]
    fn a_framed_box_fills_the_picture() {
        for (aspect, high) in [(1.0, [1.0, 1.0, 1.0]), (2.0, [0.2, 3.0, 0.1]), (0.5, [4.0, 1.0, 2.0])] {
            let low = [-0.3, -0.2, -0.1];
            let camera = Camera::framing(low, high, [0.4, 0.3, 1.0], 0.6, aspect);
            let view = View::new(&camera, aspect);
            let corners = (0..8).map(|k| [0, 1, 2].map(|c| if k >> c & 1 == 1 { high[c] } else { low[c] }));
            let most = corners.map(|p| project(&view, p)).map(|p| p[0].abs().max(p[1].abs())).fold(0.0, f32::max);
            assert!((0.85..=1.0).contains(&most), "{most}");
        }
    }

    #[test]
    fn cameras_without_a_picture_are_refused() {
        let good = Camera { eye: [0.0, 0.0, 1.0], target: [0.0; 3], fov: 1.0 };
        good.check().unwrap();
        for bad in [
            Camera { eye: [0.0; 3], ..good },
            Camera { eye: [0.0, 1.0, 0.0], ..good },
            Camera { eye: [f32::NAN; 3], ..good },
            Camera { fov: 0.0, ..good },
        ] {
            assert!(bad.check().is_err(), "{bad:?}");
        }
    }
}
