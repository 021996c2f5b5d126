//! The solids that stand in for a part of a body, and how far a point is from their surface.

use nalgebra::{Matrix4, Rotation3, UnitQuaternion, Vector3};
use serde::Serialize;

use crate::base::mesh::Joint;

/// Steps in which the rotation of a transform is sought, at most: one that is sheared strongly has none that is right.
const MAX_TURNS: usize = 200;

/// The form of a solid, in its own frame \[m\].
#[derive(Clone, Copy, Debug, PartialEq, Serialize)]
#[serde(rename_all = "snake_case")]
pub enum Form {
    /// A ball around the origin.
    Sphere {
        /// Its radius.
        radius: f64,
    },
    /// All points nearer than `radius` to a segment of the y axis.
    Capsule {
        /// Half the length of the segment.
        half_height: f64,
        /// Its radius.
        radius: f64,
    },
    /// The convex hull of two balls at the ends of a segment of the y axis.
    TaperedCapsule {
        /// Half the length of the segment.
        half_height: f64,
        /// Radii of the balls at -y and at +y, which differ by less than the length of the segment.
        radii: [f64; 2],
    },
    /// A box around the origin.
    Box {
        /// Half its sides.
        half: [f64; 3],
    },
    /// An ellipsoid around the origin.
    Ellipsoid {
        /// Its radii.
        radii: [f64; 3],
    },
}

/// A solid at its place.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Solid {
    /// Its form.
    pub form: Form,
    /// The origin of its frame \[m\].
    pub center: [f64; 3],
    /// The rotation of its frame, a quaternion (x, y, z, w).
    pub rotation: [f64; 4],
}

impl Solid {
    pub(super) fn new(form: Form, center: Vector3<f64>, turn: &Rotation3<f64>) -> Self {
        let q = UnitQuaternion::from_rotation_matrix(turn);
        Solid { form, center: center.into(), rotation: q.coords.into() }
    }

    /// The rotation of its frame.
    pub(super) fn turn(&self) -> Rotation3<f64> {
        let [x, y, z, w] = self.rotation;
        UnitQuaternion::from_quaternion(nalgebra::Quaternion::new(w, x, y, z)).to_rotation_matrix()
    }

    /// The solid moved from the pose in which the mesh is bound to where the joint is in the file, with its scale; the same solid if the
    /// transform of the joint is flat.
    pub(super) fn posed(&self, joint: &Joint) -> Self {
        let to_world = Matrix4::from_column_slice(&joint.world) * Matrix4::from_column_slice(&joint.inverse_bind);
        let linear = to_world.fixed_view::<3, 3>(0, 0).into_owned();
        // Of a mirror this is the mirrored matrix with its signs changed, which also turns a solid about its centre.
        let scale = linear.determinant().cbrt();
        let center = to_world.transform_point(&Vector3::from(self.center).into()).coords;
        let turn = linear / scale;
        if !center.iter().chain(turn.iter()).all(|x| x.is_finite()) {
            return *self;
        }
        let turn = Rotation3::from_matrix_eps(&turn, 1e-10, MAX_TURNS, Rotation3::identity());
        if !turn.matrix().iter().all(|x| x.is_finite()) {
            return *self;
        }
        let form = self.form.scaled(scale.abs());
        let form = if scale < 0.0 { form.mirrored() } else { form };
        Solid::new(form, center, &(turn * self.turn()))
    }

    /// Distance \[m\] of a point from the surface, negative inside. That of an ellipsoid is exact to 1e-7 of its size.
    pub fn distance(&self, p: [f64; 3]) -> f64 {
        let local = self.turn().inverse_transform_vector(&(Vector3::from(p) - Vector3::from(self.center)));
        self.form.distance(local)
    }
}

impl Form {
    /// As [`Solid::distance`], of a point of its own frame.
    pub(super) fn distance(&self, p: Vector3<f64>) -> f64 {
        match *self {
            Form::Sphere { radius } => p.norm() - radius,
            Form::Capsule { half_height, radius } => {
                let y = p.y - p.y.clamp(-half_height, half_height);
                Vector3::new(p.x, y, p.z).norm() - radius
            }
            Form::TaperedCapsule { half_height, radii: [low, high] } => {
                // All balls between both belong to it; of the one on the way along the normal of the cone the surface is nearest.
                let (length, drop) = (2.0 * half_height, low - high);
                let slope = drop / ((length - drop) * (length + drop)).max(f64::MIN_POSITIVE).sqrt();
                let y = (p.y - p.x.hypot(p.z) * slope).clamp(-half_height, half_height);
                Vector3::new(p.x, p.y - y, p.z).norm() - (0.5 * (low + high) - y * drop / length)
            }
            Form::Box { half } => {
                let out = Vector3::from_fn(|k, _| p[k].abs() - half[k]);
                out.map(|x| x.max(0.0)).norm() + out.max().min(0.0)
            }
            Form::Ellipsoid { radii } => to_ellipsoid(p, radii),
        }
    }

    /// A cheap distance that is exact to first order near the surface, for fits.
    pub(super) fn near_distance(&self, p: Vector3<f64>) -> f64 {
        let Form::Ellipsoid { radii } = *self else { return self.distance(p) };
        let scaled = Vector3::from_fn(|k, _| p[k] / radii[k]);
        let slope = Vector3::from_fn(|k, _| scaled[k] / radii[k]).norm();
        let size = scaled.norm();
        if slope > 0.0 { size * (size - 1.0) / slope } else { -radii.into_iter().fold(f64::INFINITY, f64::min) }
    }

    /// Half the sides of the box around it, in its own frame.
    pub(super) fn half_extents(&self) -> [f64; 3] {
        match *self {
            Form::Sphere { radius } => [radius; 3],
            Form::Capsule { half_height, radius } => [radius, half_height + radius, radius],
            Form::TaperedCapsule { half_height, radii: [low, high] } => {
                let radius = low.max(high);
                [radius, half_height + radius, radius]
            }
            Form::Box { half } => half,
            Form::Ellipsoid { radii } => radii,
        }
    }

    /// The smallest distance through its middle.
    pub(super) fn thickness(&self) -> f64 {
        2.0 * match *self {
            Form::Sphere { radius } | Form::Capsule { radius, .. } => radius,
            Form::TaperedCapsule { radii: [low, high], .. } => low.min(high),
            Form::Box { half: sizes } | Form::Ellipsoid { radii: sizes } => {
                sizes.into_iter().fold(f64::INFINITY, f64::min)
            }
        }
    }

    /// With a surface that lies deeper by `depth`, less than half the thickness.
    pub(super) fn shrunk(self, depth: f64) -> Self {
        match self {
            Form::Sphere { radius } => Form::Sphere { radius: radius - depth },
            Form::Capsule { half_height, radius } => Form::Capsule { half_height, radius: radius - depth },
            Form::TaperedCapsule { half_height, radii } => {
                Form::TaperedCapsule { half_height, radii: radii.map(|r| r - depth) }
            }
            Form::Box { half } => Form::Box { half: half.map(|h| h - depth) },
            Form::Ellipsoid { radii } => Form::Ellipsoid { radii: radii.map(|r| r - depth) },
        }
    }

    /// With sizes times `by`.
    fn scaled(self, by: f64) -> Self {
        match self {
            Form::Sphere { radius } => Form::Sphere { radius: by * radius },
            Form::Capsule { half_height, radius } => {
                Form::Capsule { half_height: by * half_height, radius: by * radius }
            }
            Form::TaperedCapsule { half_height, radii } => {
                Form::TaperedCapsule { half_height: by * half_height, radii: radii.map(|r| by * r) }
            }
            Form::Box { half } => Form::Box { half: half.map(|h| by * h) },
            Form::Ellipsoid { radii } => Form::Ellipsoid { radii: radii.map(|r| by * r) },
        }
    }

    /// As long along its longest axis, and `by` times as wide across it, which is at most 1; of a sphere all is `by` times as large.
    pub(super) fn narrowed(self, by: f64) -> Self {
        let across = |sizes: [f64; 3]| {
            let longest = (1..3).fold(0, |a, b| if sizes[b] > sizes[a] { b } else { a });
            std::array::from_fn(|n| if n == longest { sizes[n] } else { by * sizes[n] })
        };
        match self {
            Form::Sphere { radius } => Form::Sphere { radius: by * radius },
            Form::Capsule { half_height, radius } => {
                Form::Capsule { half_height: half_height + (1.0 - by) * radius, radius: by * radius }
            }
            Form::TaperedCapsule { half_height, radii } => {
                let ends = 0.5 * (radii[0] + radii[1]);
                Form::TaperedCapsule { half_height: half_height + (1.0 - by) * ends, radii: radii.map(|r| by * r) }
            }
            Form::Box { half } => Form::Box { half: across(half) },
            Form::Ellipsoid { radii } => Form::Ellipsoid { radii: across(radii) },
        }
    }

    /// As a mirror in its middle shows it.
    fn mirrored(self) -> Self {
        match self {
            Form::TaperedCapsule { half_height, radii: [low, high] } => {
                Form::TaperedCapsule { half_height, radii: [high, low] }
            }
            other => other,
        }
    }

    /// Its volume \[m3\].
    pub fn volume(&self) -> f64 {
        use std::f64::consts::PI;
        match *self {
            Form::Sphere { radius } => 4.0 / 3.0 * PI * radius.powi(3),
            Form::Capsule { half_height, radius } => PI * radius * radius * (2.0 * half_height + 4.0 / 3.0 * radius),
            Form::TaperedCapsule { half_height, radii: [low, high] } => {
                // A frustum between the circles where the cone touches the balls, and a cap of each.
                let along = (low - high) / (2.0 * half_height);
                let across = (1.0 - along * along).max(0.0).sqrt();
                let (a, b) = (low * across, high * across);
                let length = 2.0 * half_height + (high - low) * along;
                let cap = |radius: f64, height: f64| PI * height * height * (3.0 * radius - height) / 3.0;
                let frustum = PI * length * (a * a + a * b + b * b) / 3.0;
                frustum + cap(low, low * (1.0 + along)) + cap(high, high * (1.0 - along))
            }
            Form::Box { half } => 8.0 * half.iter().product::<f64>(),
            Form::Ellipsoid { radii } => 4.0 / 3.0 * PI * radii.iter().product::<f64>(),
        }
    }
}

/// Signed distance to an ellipsoid: the nearest point is `r^2 p / (t + r^2)` with the root t of a decreasing function (Eberly,
/// "Distance from a point to an ellipse, an ellipsoid, or a hyperellipsoid"), found by bisection.
fn to_ellipsoid(p: Vector3<f64>, radii: [f64; 3]) -> f64 {
    let p = p.abs();
    let least = radii.iter().copied().fold(f64::INFINITY, f64::min);
    let inside = (0..3).map(|k| (p[k] / radii[k]).powi(2)).sum::<f64>() < 1.0;
    // A point on the plane of symmetry across the shortest axis would have no root; a small shift gives it one.
    let tiny = 1e-7 * least;
    let p = Vector3::from_fn(|k, _| p[k].max(tiny));
    let sum = |t: f64| (0..3).map(|k| (radii[k] * p[k] / (t + radii[k] * radii[k])).powi(2)).sum::<f64>() - 1.0;
    let shortest = (0..3).min_by(|a, b| radii[*a].total_cmp(&radii[*b])).unwrap_or(0);
    let (mut low, mut high) = (-least * least + least * p[shortest], 0.0f64);
    if !inside {
        (low, high) = (0.0, radii.iter().copied().fold(0.0, f64::max) * p.norm());
    }
    for _ in 0..80 {
        let middle = 0.5 * (low + high);
        (low, high) = if sum(middle) > 0.0 { (middle, high) } else { (low, middle) };
    }
    let t = 0.5 * (low + high);
    let nearest = Vector3::from_fn(|k, _| radii[k] * radii[k] * p[k] / (t + radii[k] * radii[k]));
    let distance = (p - nearest).norm();
    if inside { -distance } else { distance }
}
