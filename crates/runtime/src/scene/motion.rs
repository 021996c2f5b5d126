//! Motion given by keys: positions in between are linear, rotations spherical linear (K. Shoemake, "Animating Rotation
//! with Quaternion Curves", SIGGRAPH 1985).

use crate::collider::Collider;
use crate::error::{Result, check};
use crate::moving_frame::product;
use crate::number::turn::quaternion;

/// Where something is.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Pose {
    /// Position \[m\].
    pub position: [f32; 3],
    /// Unit quaternion x, y, z, w.
    pub rotation: [f32; 4],
}

impl Default for Pose {
    fn default() -> Self {
        Pose { position: [0.0; 3], rotation: [0.0, 0.0, 0.0, 1.0] }
    }
}

impl Pose {
    /// A pose that takes the axes of the world to these three, which are orthogonal unit vectors.
    pub fn of_axes(position: [f32; 3], axes: &[[f64; 3]; 3]) -> Self {
        Pose { position, rotation: quaternion(axes).map(|x| x as f32) }
    }

    /// Velocity \[m/s\] and angular velocity \[rad/s\] that lead to `next` in `dt` \[s\], the shorter way round.
    pub fn motion_to(&self, next: &Pose, dt: f64) -> ([f32; 3], [f32; 3]) {
        let velocity = [0, 1, 2].map(|c| (f64::from(next.position[c] - self.position[c]) / dt) as f32);
        let [x, y, z, w] = self.rotation.map(f64::from);
        let turn = product(next.rotation.map(f64::from), [-x, -y, -z, w]);
        let turn = if turn[3] < 0.0 { turn.map(|t| -t) } else { turn };
        let sine = turn[..3].iter().map(|t| t * t).sum::<f64>().sqrt();
        let rate = if sine > 0.0 { 2.0 * sine.atan2(turn[3]) / (sine * dt) } else { 0.0 };
        (velocity, [0, 1, 2].map(|c| (turn[c] * rate) as f32))
    }

    /// The columns of the matrix that does the same, the last being the position.
    pub fn columns(&self) -> [[f32; 4]; 4] {
        let [x, y, z, w] = self.rotation.map(f64::from);
        let column = |c: [f64; 3]| [c[0] as f32, c[1] as f32, c[2] as f32, 0.0];
        let [a, b, c] = self.position;
        [
            column([1.0 - 2.0 * (y * y + z * z), 2.0 * (x * y + z * w), 2.0 * (x * z - y * w)]),
            column([2.0 * (x * y - z * w), 1.0 - 2.0 * (x * x + z * z), 2.0 * (y * z + x * w)]),
            column([2.0 * (x * z + y * w), 2.0 * (y * z - x * w), 1.0 - 2.0 * (x * x + y * y)]),
            [a, b, c, 1.0],
        ]
    }

    /// The pose that does what `first` does, then this one.
    pub(crate) fn after(&self, first: &Pose) -> Pose {
        let rotation = product(self.rotation.map(f64::from), first.rotation.map(f64::from));
        let norm = rotation.iter().map(|x| x * x).sum::<f64>().sqrt();
        Pose { position: self.apply(first.position), rotation: rotation.map(|x| (x / norm) as f32) }
    }

    /// The same with a unit quaternion. Errors on numbers that are not finite, and on a rotation of no length.
    pub(crate) fn checked(&self) -> Result<Pose> {
        for x in self.position {
            check("the position of a pose [m]", x.into(), "finite", |_| true)?;
        }
        let norm = self.rotation.iter().map(|x| f64::from(*x).powi(2)).sum::<f64>().sqrt();
        check("the length of a pose's rotation", norm, "above 0", |n| n > 1e-6)?;
        Ok(Pose { rotation: self.rotation.map(|x| (f64::from(x) / norm) as f32), ..*self })
    }

    /// A point of the body's own frame in the world.
    pub fn apply(&self, p: [f32; 3]) -> [f32; 3] {
        let q = self.rotation;
        let cross = |a: [f32; 3], b: [f32; 3]| crate::number::real::cross(a, b);
        let axis = [q[0], q[1], q[2]];
        let t = cross(axis, p).map(|x| 2.0 * x);
        let u = cross(axis, t);
        [0, 1, 2].map(|c| p[c] + q[3] * t[c] + u[c] + self.position[c])
    }
}

impl Collider {
    /// Where it is.
    pub fn pose(&self) -> Pose {
        Pose { position: self.center, rotation: self.rotation }
    }

    /// Itself at the second of two poses that are `dt` \[s\] apart, with the velocity and spin that lead there from the first,
    /// the shorter way round; at rest if `dt` is not above 0, or so short that they are not finite.
    pub fn moved(self, from: &Pose, to: &Pose, dt: f64) -> Collider {
        let (velocity, spin) = from.motion_to(to, dt);
        let finite = [velocity, spin].as_flattened().iter().all(|x| x.is_finite());
        let (velocity, spin) = if finite && dt > 0.0 { (velocity, spin) } else { ([0.0; 3], [0.0; 3]) };
        Collider { center: to.position, rotation: to.rotation, velocity, spin, ..self }
    }
}

/// A pose at a time.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Key {
    /// When \[s\] since the start.
    pub time: f64,
    /// Where.
    pub pose: Pose,
}

/// Keys in the order of time.
#[derive(Clone, Debug, PartialEq)]
pub struct Motion(Vec<Key>);

impl Motion {
    /// Errors on no keys, times that do not rise from 0 or more, and numbers that are not finite. Rotations are made
    /// unit quaternions; one of no length is refused.
    pub fn new(mut keys: Vec<Key>) -> Result<Self> {
        check("the number of keys of a motion", keys.len() as f64, "at least 1", |n| n >= 1.0)?;
        let mut least = -f64::MIN_POSITIVE;
        for key in &mut keys {
            check("the time of a key [s]", key.time, "at least 0 and after the key before it", |t| t > least)?;
            least = key.time;
            for x in key.pose.position {
                check("the position of a key [m]", x.into(), "finite", |_| true)?;
            }
            let norm = key.pose.rotation.iter().map(|x| f64::from(*x).powi(2)).sum::<f64>().sqrt();
            check("the length of a key's rotation", norm, "above 0", |n| n > 1e-6)?;
            key.pose.rotation = key.pose.rotation.map(|x| (f64::from(x) / norm) as f32);
        }
        Ok(Motion(keys))
    }

    /// Where it is at `time` \[s\]: at the first key before it, at the last after it.
    pub fn at(&self, time: f64) -> Pose {
        let next = self.0.partition_point(|k| k.time <= time);
        let (Some(a), b) = (self.0.get(next.saturating_sub(1)), self.0.get(next)) else { return Pose::default() };
        let Some(b) = b.filter(|_| next > 0) else { return a.pose };
        let s = (time - a.time) / (b.time - a.time);
        let (p, q) = (a.pose.position, b.pose.position);
        let position = [0, 1, 2].map(|c| (f64::from(p[c]) + (f64::from(q[c]) - f64::from(p[c])) * s) as f32);
        Pose { position, rotation: slerp(a.pose.rotation, b.pose.rotation, s) }
    }

    /// Time \[s\] of the last key.
    pub fn end(&self) -> f64 {
        self.0.last().map_or(0.0, |k| k.time)
    }
}

fn slerp(a: [f32; 4], b: [f32; 4], s: f64) -> [f32; 4] {
    let (a, mut b) = (a.map(f64::from), b.map(f64::from));
    let mut cosine: f64 = (0..4).map(|c| a[c] * b[c]).sum();
    if cosine < 0.0 {
        (b, cosine) = (b.map(|x| -x), -cosine);
    }
    let angle = cosine.min(1.0).acos();
    // Nearly alike: the chord is as good as the arc, and has no division by 0.
    let (wa, wb) = if angle < 1e-4 {
        (1.0 - s, s)
    } else {
        (((1.0 - s) * angle).sin() / angle.sin(), (s * angle).sin() / angle.sin())
    };
    let sum = [0, 1, 2, 3].map(|c| wa * a[c] + wb * b[c]);
    let norm = sum.iter().map(|x| x * x).sum::<f64>().sqrt();
    sum.map(|x| (x / norm) as f32)
}

/// The unit quaternion of a turn about an axis, which need not be a unit vector; none about one of no length.
pub fn about(axis: [f32; 3], radians: f64) -> [f32; 4] {
    let norm = axis.iter().map(|x| f64::from(*x).powi(2)).sum::<f64>().sqrt();
    let (sine, cosine) = (radians / 2.0).sin_cos();
    let by = if norm > 0.0 { sine / norm } else { 0.0 };
    let [x, y, z] = axis.map(|x| (f64::from(x) * by) as f32);
    if norm > 0.0 { [x, y, z, cosine as f32] } else { [0.0, 0.0, 0.0, 1.0] }
}

#[cfg(test)]
mod tests {
    use std::f64::consts::{FRAC_PI_2, FRAC_PI_4};

    use super::*;

    fn near(a: &[f32], b: &[f32]) -> bool {
        a.iter().zip(b).all(|(a, b)| (a - b).abs() < 1e-6)
    }

    fn quarter() -> Motion {
        let to = Pose { position: [2.0, 0.0, -4.0], rotation: about([0.0, 3.0, 0.0], FRAC_PI_2) };
        Motion::new(vec![Key { time: 1.0, pose: Pose::default() }, Key { time: 3.0, pose: to }]).unwrap()
    }

    #[test]
    fn between_keys_it_is_linear_and_on_the_great_circle() {
        let motion = quarter();
        let middle = motion.at(2.0);
        assert!(near(&middle.position, &[1.0, 0.0, -2.0]));
        assert!(near(&middle.rotation, &about([0.0, 1.0, 0.0], FRAC_PI_4)));
        assert_eq!((motion.at(-1.0), motion.at(9.0), motion.end()), (motion.at(1.0), motion.at(3.0), 3.0));
        // A quarter turn about +y takes z to x.
        assert!(near(&motion.at(3.0).apply([0.0, 0.0, 1.0]), &[3.0, 0.0, -4.0]));
    }

    #[test]
    fn velocities_lead_from_pose_to_pose() {
        let motion = quarter();
        let (velocity, spin) = motion.at(1.0).motion_to(&motion.at(1.5), 0.5);
        assert!(near(&velocity, &[1.0, 0.0, -2.0]));
        assert!(near(&spin, &[0.0, FRAC_PI_4 as f32, 0.0]), "{spin:?}");
        let still = motion.at(5.0);
        assert_eq!(still.motion_to(&still, 0.1), ([0.0; 3], [0.0; 3]));
        // A quaternion with the opposite sign is the same rotation.
        let other = Pose { rotation: still.rotation.map(|x| -x), ..still };
        assert!(near(&still.motion_to(&other, 0.1).1, &[0.0; 3]));
    }

    #[test]
    fn bad_keys_are_refused() {
        let key = |time| Key { time, pose: Pose::default() };
        assert!(Motion::new(vec![]).is_err());
        assert!(Motion::new(vec![key(1.0), key(1.0)]).is_err());
        assert!(Motion::new(vec![key(-1.0)]).is_err());
        assert!(Motion::new(vec![key(f64::NAN)]).is_err());
        let flat = Pose { rotation: [0.0; 4], ..Pose::default() };
        assert!(Motion::new(vec![Key { time: 0.0, pose: flat }]).is_err());
        assert!(Motion::new(vec![key(0.0)]).is_ok());
    }
}
