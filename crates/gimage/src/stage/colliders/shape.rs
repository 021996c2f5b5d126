//! A solid as a list of numbers, which a fit changes.

use nalgebra::{Matrix3, Rotation3, SymmetricEigen, Vector3};

use super::samples::Sample;
use super::solid::{Form, Solid};

/// The kinds of solids that may be fitted.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord)]
pub enum Kind {
    /// [`Form::Sphere`].
    Sphere,
    /// [`Form::Capsule`].
    Capsule,
    /// [`Form::TaperedCapsule`].
    TaperedCapsule,
    /// [`Form::Box`].
    Box,
    /// [`Form::Ellipsoid`].
    Ellipsoid,
}

impl Kind {
    /// All of them, the cheapest contact first.
    pub const ALL: [Kind; 5] = [Kind::Sphere, Kind::Capsule, Kind::TaperedCapsule, Kind::Box, Kind::Ellipsoid];

    /// Its name, as in scene files.
    pub fn name(self) -> &'static str {
        match self {
            Kind::Sphere => "sphere",
            Kind::Capsule => "capsule",
            Kind::TaperedCapsule => "tapered_capsule",
            Kind::Box => "box",
            Kind::Ellipsoid => "ellipsoid",
        }
    }

    /// How much smaller than that of a cheaper kind the error must be.
    pub(super) fn handicap(self) -> f64 {
        match self {
            Kind::Sphere | Kind::Capsule => 1.0,
            Kind::TaperedCapsule => 1.05,
            Kind::Box => 1.1,
            Kind::Ellipsoid => 1.25,
        }
    }
}

/// Half the length of a tapered capsule, at least, over the difference of its radii.
const LEAST_LENGTH: f64 = 0.51;

/// A solid and the frame in which its numbers are small rotations.
#[derive(Clone, Debug)]
pub(super) struct Shape {
    pub kind: Kind,
    frame: Rotation3<f64>,
    /// The centre, a rotation vector in the frame, and the logarithms of the sizes.
    pub numbers: Vec<f64>,
}

impl Shape {
    pub fn of(solid: &Solid) -> Self {
        let (kind, sizes) = match solid.form {
            Form::Sphere { radius } => (Kind::Sphere, vec![radius]),
            Form::Capsule { half_height, radius } => (Kind::Capsule, vec![half_height, radius]),
            Form::TaperedCapsule { half_height, radii: [low, high] } => {
                (Kind::TaperedCapsule, vec![half_height, low, high])
            }
            Form::Box { half } => (Kind::Box, half.to_vec()),
            Form::Ellipsoid { radii } => (Kind::Ellipsoid, radii.to_vec()),
        };
        let mut numbers = solid.center.to_vec();
        numbers.extend([0.0; 3]);
        numbers.extend(sizes.iter().map(|s| s.max(1e-9).ln()));
        Shape { kind, frame: solid.turn(), numbers }
    }

    pub fn solid(&self) -> Solid {
        Solid::new(self.form(), self.center(), &self.turn())
    }

    fn center(&self) -> Vector3<f64> {
        Vector3::new(self.numbers[0], self.numbers[1], self.numbers[2])
    }

    fn turn(&self) -> Rotation3<f64> {
        self.frame * Rotation3::new(Vector3::new(self.numbers[3], self.numbers[4], self.numbers[5]))
    }

    fn form(&self) -> Form {
        let size = |k: usize| self.numbers[6 + k].clamp(-20.0, 20.0).exp();
        match self.kind {
            Kind::Sphere => Form::Sphere { radius: size(0) },
            Kind::Capsule => Form::Capsule { half_height: size(0), radius: size(1) },
            Kind::TaperedCapsule => {
                let radii = [size(1), size(2)];
                // One ball must not hold the other.
                let half_height = size(0).max(LEAST_LENGTH * (radii[0] - radii[1]).abs());
                Form::TaperedCapsule { half_height, radii }
            }
            Kind::Box => Form::Box { half: [size(0), size(1), size(2)] },
            Kind::Ellipsoid => Form::Ellipsoid { radii: [size(0), size(1), size(2)] },
        }
    }

    /// Distances of samples from its surface, negative inside; those of an ellipsoid to first order.
    pub fn distances(&self, samples: &[Sample], out: &mut Vec<f64>) {
        let (form, center, turn) = (self.form(), self.center(), self.turn());
        out.clear();
        out.extend(
            samples
                .iter()
                .map(|s| form.near_distance(turn.inverse_transform_vector(&(Vector3::from(s.point) - center)))),
        );
    }
}

/// A first guess for the surface through `points`: the box of their principal axes, its longest side along y.
pub(super) fn guess(kind: Kind, points: &[[f64; 3]]) -> Option<Solid> {
    let n = points.len() as f64;
    let mean = points.iter().map(|p| Vector3::from(*p)).sum::<Vector3<f64>>() / n.max(1.0);
    let spread: Matrix3<f64> = points.iter().map(|p| Vector3::from(*p) - mean).map(|d| d * d.transpose()).sum();
    if points.is_empty() || !spread.iter().all(|x| x.is_finite()) {
        return None;
    }
    let eigen = SymmetricEigen::new(spread);
    let mut order = [0, 1, 2];
    order.sort_by(|a, b| eigen.eigenvalues[*b].total_cmp(&eigen.eigenvalues[*a]));
    let y = eigen.eigenvectors.column(order[0]).into_owned();
    let x = eigen.eigenvectors.column(order[1]).into_owned();
    let turn = Rotation3::from_matrix_unchecked(Matrix3::from_columns(&[x, y, x.cross(&y)]));
    let local: Vec<_> = points.iter().map(|p| turn.inverse_transform_vector(&(Vector3::from(*p) - mean))).collect();
    let low = local.iter().fold(Vector3::repeat(f64::INFINITY), |low, p| low.inf(p));
    let high = local.iter().fold(Vector3::repeat(f64::NEG_INFINITY), |high, p| high.sup(p));
    let half = (0.5 * (high - low)).map(|h| h.max(1e-4 * (high - low).max()).max(1e-9));
    let center = mean + turn * (0.5 * (low + high));
    let across = 0.5 * (half.x + half.z);
    let form = match kind {
        Kind::Sphere => Form::Sphere { radius: (half.x + half.y + half.z) / 3.0 },
        Kind::Capsule => Form::Capsule { half_height: (half.y - across).max(0.1 * half.y), radius: across },
        Kind::TaperedCapsule => {
            let radii =
                radii(&local, 0.5 * (low.y + high.y)).map(|r| r.unwrap_or(across).clamp(0.2 * across, 5.0 * across));
            let half_height = (half.y - 0.5 * (radii[0] + radii[1])).max(0.1 * half.y);
            Form::TaperedCapsule { half_height: half_height.max(LEAST_LENGTH * (radii[0] - radii[1]).abs()), radii }
        }
        Kind::Box => Form::Box { half: half.into() },
        Kind::Ellipsoid => Form::Ellipsoid { radii: half.into() },
    };
    Some(Solid::new(form, center, &turn))
}

/// The mean distances from the y axis of the points below and above a height; none without points.
fn radii(points: &[Vector3<f64>], height: f64) -> [Option<f64>; 2] {
    [false, true].map(|above| {
        let own = points.iter().filter(|p| (p.y > height) == above).map(|p| p.x.hypot(p.z));
        let (count, sum) = own.fold((0.0, 0.0), |(count, sum), r| (count + 1.0, sum + r));
        (count > 0.0).then(|| sum / count)
    })
}
