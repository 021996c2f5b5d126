//! Rotations, and the pose of a leg whose foot is given.

use crate::math::{V3, add, cos, cross, dot, norm, scale, sin, sub, unit};

/// A unit quaternion x, y, z, w.
pub type Quat = [f64; 4];

/// No rotation.
pub const STILL: Quat = [0.0, 0.0, 0.0, 1.0];

/// A rotation about an axis of length 1 by an angle \[rad\].
pub fn about(axis: V3, angle: f64) -> Quat {
    let [x, y, z] = scale(axis, sin(angle / 2.0));
    [x, y, z, cos(angle / 2.0)]
}

/// About x, y or z.
pub fn pitch(angle: f64) -> Quat {
    about([1.0, 0.0, 0.0], angle)
}

/// About the vertical axis; positive angles turn to the left.
pub fn yaw(angle: f64) -> Quat {
    about([0.0, 1.0, 0.0], angle)
}

/// About the axis forward; positive angles raise the left side.
pub fn roll(angle: f64) -> Quat {
    about([0.0, 0.0, 1.0], angle)
}

/// First `b`, then `a`.
pub fn times(a: Quat, b: Quat) -> Quat {
    let (u, v) = ([a[0], a[1], a[2]], [b[0], b[1], b[2]]);
    let w = add(add(scale(v, a[3]), scale(u, b[3])), cross(u, v));
    [w[0], w[1], w[2], a[3] * b[3] - dot(u, v)]
}

/// The rotation back.
pub fn inverse([x, y, z, w]: Quat) -> Quat {
    [-x, -y, -z, w]
}

/// A turned vector.
pub fn turn(q: Quat, v: V3) -> V3 {
    let u = [q[0], q[1], q[2]];
    let t = scale(cross(u, v), 2.0);
    add(add(v, scale(t, q[3])), cross(u, t))
}

/// The shortest rotation from one direction to another that is not opposite.
fn between(from: V3, to: V3) -> Quat {
    let (from, to) = (unit(from), unit(to));
    let middle = unit(add(from, to));
    let [x, y, z] = cross(from, middle);
    [x, y, z, dot(from, middle)]
}

/// Smallest bend of a knee \[rad\]: a straight leg snaps.
const LEAST_BEND: f64 = 0.08;

/// The rotation of the thigh and the bend of the knee \[rad\] for which the ankle is at `to` from the hip, or as near as it gets. `thigh`
/// and `shin` lead from joint to joint in the bind pose.
pub fn reach(thigh: V3, shin: V3, to: V3) -> (Quat, f64) {
    let far = |bend: f64| add(thigh, turn(pitch(bend), shin));
    let (mut low, mut high) = (LEAST_BEND, 2.4);
    for _ in 0..40 {
        let middle = (low + high) / 2.0;
        if norm(far(middle)) > norm(to) { low = middle } else { high = middle }
    }
    (between(far(low), to), low)
}

/// From `a` to `b` with given speeds at both ends, all per unit of `t` in 0..=1.
pub fn hermite(a: f64, b: f64, [from, to]: [f64; 2], t: f64) -> f64 {
    let (t2, t3) = (t * t, t * t * t);
    a * (2.0 * t3 - 3.0 * t2 + 1.0) + b * (3.0 * t2 - 2.0 * t3) + from * (t3 - 2.0 * t2 + t) + to * (t3 - t2)
}

/// A bone from joint to joint.
pub fn bone(from: [f32; 3], to: [f32; 3]) -> V3 {
    sub(to.map(f64::from), from.map(f64::from))
}
