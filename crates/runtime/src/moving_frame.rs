//! A moving frame of reference that a cloth is simulated in, and the shares of its motion that the cloth feels.
//!
//! Free particles go on through the world: in the frame they feel a linear acceleration, the Euler and the Coriolis force, and the
//! centrifugal force. All are impulses between two frames of the host, taken from the Verlet step that a particle makes in the world, so that a
//! particle without forces keeps its straight way exactly however fast the frame turns.

use crate::error::{Result, check};
use crate::number::real::{add, dot, scale, sub};
use crate::number::turn::quaternion;

/// Where a frame of reference is. In f64, so that it may be far from the origin of the world.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct MovingFrame {
    /// Its origin \[m\].
    pub position: [f64; 3],
    /// Unit quaternion x, y, z, w.
    pub rotation: [f64; 4],
}

/// Shares of the motion of a [`MovingFrame`] that a cloth feels, 0 to 1 each. 1 is what happens in the world; at 0 the cloth
/// moves with the frame as if that stood still.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Inertia {
    /// Of the acceleration of its origin, and of its velocity against the air.
    pub linear: f32,
    /// Of the Euler and the Coriolis force as it turns.
    pub angular: f32,
    /// Of the centrifugal force, away from the axis through its origin.
    pub centrifugal: f32,
}

impl Default for Inertia {
    fn default() -> Self {
        Inertia { linear: 1.0, angular: 1.0, centrifugal: 1.0 }
    }
}

/// Where a frame is, and how it moved in the last frame of the host that made a step: all that a save game needs of it.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct FrameMotion {
    /// Where it is.
    pub frame: MovingFrame,
    /// Velocity of its origin in the world \[m/s\].
    pub velocity: [f64; 3],
    /// Its turn, as a unit quaternion that takes coordinates in it from before the turn to after it.
    pub turn: [f64; 4],
    /// How long that took \[s\].
    pub seconds: f64,
}

impl Default for MovingFrame {
    fn default() -> Self {
        MovingFrame { position: [0.0; 3], rotation: STILL }
    }
}

impl MovingFrame {
    /// A frame with these axes, which are orthogonal unit vectors in the world.
    pub fn of_axes(position: [f64; 3], axes: &[[f64; 3]; 3]) -> Self {
        MovingFrame { position, rotation: quaternion(axes) }
    }

    /// A point of the frame in the world.
    pub fn to_world(&self, p: [f64; 3]) -> [f64; 3] {
        add(rotate(self.rotation, p), self.position)
    }

    /// A point of the world in the frame.
    pub fn to_local(&self, p: [f64; 3]) -> [f64; 3] {
        rotate(inverse(self.rotation), sub(p, self.position))
    }

    /// A share of the way to another one, the shorter way round.
    pub(crate) fn towards(&self, to: &MovingFrame, along: f64) -> Self {
        let way = scale(sub(to.position, self.position), along);
        let turn = share(product(to.rotation, inverse(self.rotation)), along);
        MovingFrame { position: add(self.position, way), rotation: product(turn, self.rotation) }
    }

    /// The same with a unit quaternion. Errors on numbers that are not finite, and on a rotation of no length.
    pub(crate) fn checked(&self) -> Result<Self> {
        for x in self.position {
            check("the position of a moving frame [m]", x, "finite", |_| true)?;
        }
        Ok(MovingFrame { rotation: unit("the length of a moving frame's rotation", self.rotation)?, ..*self })
    }
}

impl Inertia {
    pub(crate) fn check(&self) -> Result<()> {
        [("linear", self.linear), ("angular", self.angular), ("centrifugal", self.centrifugal)]
            .into_iter()
            .try_for_each(|(name, x)| check(name, x.into(), "from 0 to 1", |x| (0.0..=1.0).contains(&x)))
    }
}

impl FrameMotion {
    /// At rest.
    pub fn still(frame: MovingFrame) -> Self {
        FrameMotion { frame, velocity: [0.0; 3], turn: STILL, seconds: 0.0 }
    }

    /// The same in another place: its velocity turns with it.
    pub(crate) fn put(&self, frame: MovingFrame) -> Self {
        let by = product(frame.rotation, inverse(self.frame.rotation));
        FrameMotion { frame, velocity: rotate(by, self.velocity), ..*self }
    }

    pub(crate) fn checked(&self) -> Result<Self> {
        for x in self.velocity.into_iter().chain([self.seconds]) {
            check("the motion of a moving frame", x, "finite", |_| true)?;
        }
        let turn = unit("the length of the turn of a moving frame", self.turn)?;
        Ok(FrameMotion { frame: self.frame.checked()?, turn, ..*self })
    }

    /// Goes on to `next` in `seconds`, and returns what the velocities of particles become by it; none if nothing changes.
    pub(crate) fn go(&mut self, next: MovingFrame, seconds: f64, inertia: &Inertia) -> Option<Impulse> {
        let last = *self;
        let velocity = scale(sub(next.position, last.frame.position), 1.0 / seconds);
        let turn = product(inverse(next.rotation), last.frame.rotation);
        *self = FrameMotion { frame: next, velocity, turn, seconds };
        let change = sub(velocity, last.velocity);
        if turn == last.turn && is_still(turn) && dot(change, change) < STEADY * STEADY {
            return None;
        }
        let [linear, angular, centrifugal] = [inertia.linear, inertia.angular, inertia.centrifugal].map(f64::from);
        let both = product(turn, last.turn);
        let longer = if last.seconds > 0.0 { seconds / last.seconds } else { 1.0 };
        let axes = [[1.0, 0.0, 0.0], [0.0, 1.0, 0.0], [0.0, 0.0, 1.0]];
        let stretch = axes.map(|e| {
            let (once, twice) = (rotate(turn, e), rotate(product(turn, turn), e));
            let away = sub(sub(scale(once, 2.0), twice), e);
            let all = sub(sub(scale(once, 1.0 + longer), scale(rotate(both, e), longer)), e);
            scale(add(scale(away, centrifugal), scale(sub(all, away), angular)), 1.0 / seconds)
        });
        let turned = share(both, angular);
        let shift = scale(rotate(inverse(next.rotation), change), -linear);
        Some(Impulse { turn: axes.map(|e| rotate(turned, e)), stretch, shift })
    }

    /// Gravity and wind as the frame has them half way to where it is.
    pub(crate) fn local(&self, gravity: [f64; 3], wind: [f64; 3], inertia: &Inertia) -> [[f64; 3]; 2] {
        // Coordinates turn by `turn` in the frame; half of it is taken back.
        let half = product(inverse(share(self.turn, 0.5)), inverse(self.frame.rotation));
        let air = sub(wind, scale(self.velocity, inertia.linear.into()));
        [rotate(half, gravity), rotate(half, air)]
    }
}

/// The change of velocities: v' = turn v + stretch x + shift.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Impulse {
    /// Columns of a matrix.
    turn: [[f64; 3]; 3],
    /// Columns of a matrix \[1/s\].
    stretch: [[f64; 3]; 3],
    /// \[m/s\]
    shift: [f64; 3],
}

impl Impulse {
    /// The numbers that the pass reads, for displacements of `dt` \[s\]: three columns, three columns, a shift.
    pub fn numbers(&self, dt: f64) -> [[f32; 4]; 7] {
        let [a, b, c] = self.turn;
        let [d, e, f] = self.stretch.map(|v| scale(v, dt));
        [a, b, c, d, e, f, scale(self.shift, dt)].map(|[x, y, z]| [x as f32, y as f32, z as f32, 0.0])
    }
}

const STILL: [f64; 4] = [0.0, 0.0, 0.0, 1.0];
/// A change of velocity \[m/s\] below this is rounding, also 1e6 m from the origin.
const STEADY: f64 = 1e-7;

fn is_still(turn: [f64; 4]) -> bool {
    turn[..3].iter().all(|x| x.abs() < 1e-15)
}

fn inverse([x, y, z, w]: [f64; 4]) -> [f64; 4] {
    [-x, -y, -z, w]
}

pub(crate) fn product(a: [f64; 4], b: [f64; 4]) -> [f64; 4] {
    [
        a[3] * b[0] + a[0] * b[3] + a[1] * b[2] - a[2] * b[1],
        a[3] * b[1] - a[0] * b[2] + a[1] * b[3] + a[2] * b[0],
        a[3] * b[2] + a[0] * b[1] - a[1] * b[0] + a[2] * b[3],
        a[3] * b[3] - a[0] * b[0] - a[1] * b[1] - a[2] * b[2],
    ]
}

fn rotate(q: [f64; 4], v: [f64; 3]) -> [f64; 3] {
    let axis = [q[0], q[1], q[2]];
    let t = scale(crate::number::real::cross(axis, v), 2.0);
    add(add(v, scale(t, q[3])), crate::number::real::cross(axis, t))
}

/// A share of a turn, the shorter way round.
fn share(turn: [f64; 4], share: f64) -> [f64; 4] {
    let turn = if turn[3] < 0.0 { turn.map(|x| -x) } else { turn };
    let sine = turn[..3].iter().map(|x| x * x).sum::<f64>().sqrt();
    if sine == 0.0 {
        return STILL;
    }
    let half = sine.atan2(turn[3]) * share;
    let by = half.sin() / sine;
    [turn[0] * by, turn[1] * by, turn[2] * by, half.cos()]
}

fn unit(name: &'static str, q: [f64; 4]) -> Result<[f64; 4]> {
    let norm = q.iter().map(|x| x * x).sum::<f64>().sqrt();
    check(name, norm, "above 0", |n| n > 1e-6)?;
    Ok(q.map(|x| x / norm))
}
