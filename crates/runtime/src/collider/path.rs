//! The space through which a collider moves from one pose to another.

use super::solid::Solid;
use super::{Collider, Shape};
use crate::number::real::{V3, dot, sub};

/// An axis-aligned box: its corners of the smallest and of the largest coordinates \[m\].
pub type Corners = [V3<f64>; 2];

/// The space through which a collider moves, enlarged where that is simpler.
#[derive(Clone, Debug)]
pub enum Path {
    /// Inside a box.
    Box(Corners),
    /// Near or below one of two planes.
    Planes(Planes),
    /// Unknown.
    Everywhere,
}

/// A half-space at both ends of its path.
#[derive(Clone, Debug)]
pub struct Planes {
    /// Normals, and points on the planes \[m\].
    ends: [(V3<f64>, V3<f64>); 2],
    /// Largest distance \[m\] by which planes in between are nearer, and its increase per metre from the points.
    nearer: [f64; 2],
}

impl Path {
    /// The path from one pose, or shape, to another, also of the last `seconds` of a motion by the velocity and the spin at its end.
    pub fn new(from: &Collider, to: &Collider, seconds: f64) -> Self {
        let size = |v: [f32; 3]| length(v.map(f64::from));
        let swept = seconds * (size(to.velocity) + size(to.spin) * arm(to));
        let (Some(a), Some(b)) = (extent(from), extent(to)) else {
            if from.shape != to.shape {
                return Path::Everywhere;
            }
            let ends = [from, to].map(|c| (Solid::<f64>::new(c).up(), c.center.map(f64::from)));
            // A point above two planes is above those whose normals are mixtures of theirs, but for the way between the centres.
            // Normals that turn otherwise leave the mixtures by the height of their arc.
            let way = if ends[0].0 == ends[1].0 { 0.0 } else { length(sub(ends[0].1, ends[1].1)) };
            return Path::Planes(Planes { ends, nearer: [swept + way, arc(from, to) + seconds * size(to.spin)] });
        };
        // A point on an arc leaves the straight line between its ends by the height of the arc.
        let by = swept + arm(from).max(arm(to)) * arc(from, to);
        Path::Box([[0, 1, 2].map(|c| a[0][c].min(b[0][c]) - by), [0, 1, 2].map(|c| a[1][c].max(b[1][c]) + by)])
    }

    /// Whether the path comes within `margin` \[m\] of a box. Never false if it does.
    pub fn reaches(&self, [low, high]: Corners, margin: f64) -> bool {
        match self {
            Path::Box([lowest, highest]) => {
                (0..3).all(|c| lowest[c] - margin <= high[c] && highest[c] + margin >= low[c])
            }
            Path::Planes(Planes { ends, nearer }) => ends.iter().any(|(up, at)| {
                let far = [0, 1, 2].map(|c| (low[c] - at[c]).abs().max((high[c] - at[c]).abs()));
                let lowest = [0, 1, 2].map(|c| if up[c] > 0.0 { low[c] } else { high[c] });
                let height = dot(*up, sub(lowest, *at));
                height <= margin + nearer[0] + length(far) * nearer[1] || height.is_nan()
            }),
            Path::Everywhere => true,
        }
    }
}

/// The box around a collider; none around a half-space.
fn extent(collider: &Collider) -> Option<Corners> {
    let axes = Solid::<f64>::new(collider).axes();
    let along = |c: usize, by: V3<f64>| [0, 1, 2].map(|n| axes[n][c] * by[n]);
    let half = |c: usize| match collider.shape {
        Shape::HalfSpace => f64::INFINITY,
        Shape::Sphere { radius } => f64::from(radius),
        Shape::Capsule { half_height, radius } => f64::from(half_height) * axes[1][c].abs() + f64::from(radius),
        Shape::TaperedCapsule { half_height, radii: [low, high] } => {
            f64::from(half_height) * axes[1][c].abs() + f64::from(low.max(high))
        }
        Shape::Box { half } => along(c, half.map(f64::from)).iter().map(|x| x.abs()).sum(),
        Shape::Ellipsoid { radii, .. } => along(c, radii.map(f64::from)).iter().map(|x| x * x).sum::<f64>().sqrt(),
    };
    let center = collider.center.map(f64::from);
    let [low, high] = [-1.0, 1.0].map(|side| [0, 1, 2].map(|c| center[c] + side * half(c)));
    (collider.shape != Shape::HalfSpace).then_some([low, high])
}

fn length(v: V3<f64>) -> f64 {
    dot(v, v).sqrt()
}

/// The height of the arc of a point at 1 m, from one rotation to another. Half as much again, as a collider may move while it
/// turns.
fn arc(from: &Collider, to: &Collider) -> f64 {
    let [a, b] = [from, to].map(|c| Solid::<f64>::new(c).rotation);
    1.5 * (1.0 - a.iter().zip(&b).map(|(x, y)| x * y).sum::<f64>().abs().min(1.0))
}

/// The distance \[m\] of a collider's farthest point from its centre; 0 of a half-space.
fn arm(collider: &Collider) -> f64 {
    Solid::<f64>::new(collider).around().unwrap_or(0.0)
}

#[cfg(test)]
mod tests {
    use parry3d_f64::math::{Pose, Rotation, Vector};
    use parry3d_f64::query::PointQuery;
    use parry3d_f64::shape::{Ball, Capsule, Cuboid, HalfSpace};

    use super::*;

    /// Numbers of a fixed sequence between -1 and 1.
    fn number(k: usize, of: usize) -> f64 {
        let prime = [2u32, 3, 5, 7, 11, 13, 17, 19, 23, 29][of];
        2.0 * ((k + 1) as f64 * f64::from(prime).sqrt()).fract() - 1.0
    }

    fn pose(k: usize) -> ([f32; 3], [f32; 4]) {
        let q = [3, 4, 5, 6].map(|c| number(k, c));
        let norm = q.iter().map(|x| x * x).sum::<f64>().sqrt().max(1e-3);
        ([0, 1, 2].map(|c| number(k, c) as f32), q.map(|x| (x / norm) as f32))
    }

    /// From one rotation to another, the shorter way round, evenly.
    fn between(a: [f32; 4], b: [f32; 4], t: f64) -> Rotation {
        let [a, b] =
            [a, b].map(|q| Rotation::from_xyzw(q[0].into(), q[1].into(), q[2].into(), q[3].into()).normalize());
        a.slerp(b, t)
    }

    /// Whether a point is met in 25 poses on the way, and whether the path reaches it, which it must where it is met.
    fn met_and_told(judge: &dyn PointQuery, [from, to]: [&Collider; 2], at: [f64; 3]) -> [bool; 2] {
        let near = (0..=24).map(|t| f64::from(t) / 24.0).any(|t| {
            let center = [0, 1, 2].map(|c| f64::from(from.center[c]) + t * f64::from(to.center[c] - from.center[c]));
            let pose = Pose::from_parts(Vector::from_array(center), between(from.rotation, to.rotation, t));
            judge.distance_to_point(&pose, Vector::from_array(at), true) <= 0.01
        });
        let told = Path::new(from, to, 0.0).reaches([at, at], 0.01);
        assert!(told || !near, "from {from:?} to {to:?} at {at:?}");
        [near, told]
    }

    #[test]
    fn no_point_that_is_met_on_the_way_counts_as_far() {
        let capsule = Capsule::new(Vector::new(0.0, -0.4, 0.0), Vector::new(0.0, 0.4, 0.0), 0.05);
        let cases: [(Shape, &dyn PointQuery); 3] = [
            (Shape::Sphere { radius: 0.2 }, &Ball::new(0.2)),
            (Shape::Capsule { half_height: 0.4, radius: 0.05 }, &capsule),
            (Shape::Box { half: [0.3, 0.05, 0.1] }, &Cuboid::new(Vector::new(0.3, 0.05, 0.1))),
        ];
        for (shape, judge) in cases {
            let (mut met, mut far) = (0, 0);
            for k in 0..400 {
                let ((p, q), (r, s)) = (pose(2 * k), pose(2 * k + 1));
                let from = Collider { rotation: q, ..Collider::new(shape, p) };
                let to = Collider { rotation: s, ..Collider::new(shape, r) };
                for n in 0..120 {
                    let at = [7, 8, 9].map(|c| 1.4 * number(k + 977 * n, c));
                    let [near, told] = met_and_told(judge, [&from, &to], at);
                    met += u32::from(near);
                    far += u32::from(!told);
                }
            }
            assert!(met > 100 && far > 1000, "{shape:?}: {met} met, {far} far");
        }
    }

    #[test]
    fn planes_that_tilt_reach_what_they_pass() {
        let (mut met, mut far) = (0, 0);
        for k in 0..2000 {
            let ((p, q), turn) = (pose(k), pose(k + 5000));
            let rotation = between(q, turn.1, 0.03).to_array().map(|x| x as f32);
            let center = [0, 1, 2].map(|c| p[c] + 0.05 * turn.0[c]);
            let from = Collider { rotation: q, ..Collider::new(Shape::HalfSpace, p) };
            let to = Collider { rotation, ..Collider::new(Shape::HalfSpace, center) };
            let plane = HalfSpace::new(Vector::new(0.0, 1.0, 0.0));
            let at = [7, 8, 9].map(|c| 1.4 * number(k, c));
            let [near, told] = met_and_told(&plane, [&from, &to], at);
            met += u32::from(near);
            far += u32::from(!told);
        }
        assert!(met > 500 && far > 500, "{met} met, {far} far");
    }

    #[test]
    fn planes_and_ellipsoids_reach_as_far_as_their_surface() {
        let reaches = |from: &Collider, to: &Collider, bounds, by| Path::new(from, to, 0.0).reaches(bounds, by);
        let (h, plane) = (0.5f32.sqrt(), Collider::new(Shape::HalfSpace, [0.0; 3]));
        let rotation = [0.0, 0.0, 0.125f32.sqrt(), 0.875f32.sqrt()];
        let tilted = Collider { rotation, ..Collider::new(Shape::HalfSpace, [0.0, -50.0, 0.0]) };
        let bounds = [[5.0, 0.1, -3.0], [6.0, 0.2, 3.0]];
        assert!(!reaches(&plane, &plane, bounds, 0.05) && reaches(&plane, &plane, bounds, 0.15));
        let risen = Collider { center: [0.0, 0.2, 0.0], ..plane };
        assert!(reaches(&plane, &risen, bounds, 0.0) && reaches(&risen, &plane, bounds, 0.0));
        assert!(reaches(&plane, &tilted, bounds, 0.0) && !reaches(&tilted, &tilted, bounds, 0.0));
        // A long ellipsoid reaches along x after a quarter turn about z.
        let egg = Collider::new(Shape::Ellipsoid { radii: [0.1, 1.0, 0.1], closest: true }, [0.0; 3]);
        let lying = Collider { rotation: [0.0, 0.0, h, h], ..egg };
        let beside = [[0.5, -0.05, 0.0], [0.6, 0.05, 0.0]];
        assert!(!reaches(&egg, &egg, beside, 0.01) && reaches(&lying, &lying, beside, 0.01));
        assert!(reaches(&plane, &egg, beside, 0.0));
    }

    #[test]
    fn the_velocity_extends_the_path() {
        let ball = Collider::new(Shape::Sphere { radius: 0.1 }, [0.0; 3]);
        let fast = Collider { velocity: [0.0, 50.0, 0.0], ..ball };
        let below = [[0.0, -3.0, 0.0], [0.1, -2.0, 0.1]];
        assert!(
            !Path::new(&ball, &fast, 0.02).reaches(below, 0.0) && Path::new(&ball, &fast, 0.05).reaches(below, 0.0)
        );
        let plane = Collider::new(Shape::HalfSpace, [0.0, -4.0, 0.0]);
        let rising = Collider { velocity: [0.0, 50.0, 0.0], ..plane };
        assert!(
            !Path::new(&plane, &rising, 0.01).reaches(below, 0.0)
                && Path::new(&plane, &rising, 0.05).reaches(below, 0.0)
        );
    }
}
