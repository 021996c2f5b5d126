//! A collider in numbers, and the way out of it. Twin of shaders/part/solid.wgsl.

use crate::collider::{Collider, Shape};
use crate::number::real::{Real, V3, add, cast, cross, dot, scale, sub};

pub const HALF_SPACE: u32 = 0;
pub const SPHERE: u32 = 1;
pub const CAPSULE: u32 = 2;
pub const BOX: u32 = 3;
pub const ELLIPSOID_RADIAL: u32 = 4;
pub const ELLIPSOID: u32 = 5;
pub const TAPERED: u32 = 6;

/// The fields of `Solid` in shaders/part/solid.wgsl, and what follows from them.
#[derive(Clone, Copy, Debug)]
pub struct Solid<T> {
    pub center: V3<T>,
    pub kind: u32,
    /// Radius, half height; lower radius, half height, upper radius; half sides; radii.
    pub size: V3<T>,
    pub friction: T,
    pub rotation: [T; 4],
    pub velocity: V3<T>,
    pub spin: V3<T>,
    /// Its y and x axis in the world, by the rotation.
    pub up: V3<T>,
    pub side: V3<T>,
    /// Whether it neither moves nor turns.
    pub still: bool,
}

/// The way out of a solid from a point inside.
#[derive(Clone, Copy, Debug)]
pub struct Exit<T> {
    /// Where it ends \[m\].
    pub at: V3<T>,
    /// The normal there.
    pub normal: V3<T>,
    /// Its length \[m\].
    pub depth: T,
}

impl<T: Real> Solid<T> {
    pub fn new(c: &Collider) -> Self {
        let (kind, size) = match c.shape {
            Shape::HalfSpace => (HALF_SPACE, [0.0; 3]),
            Shape::Sphere { radius } => (SPHERE, [radius, 0.0, 0.0]),
            Shape::Capsule { half_height, radius } => (CAPSULE, [radius, half_height, 0.0]),
            Shape::TaperedCapsule { half_height, radii: [low, high] } => (TAPERED, [low, half_height, high]),
            Shape::Box { half } => (BOX, half),
            Shape::Ellipsoid { radii, closest: false } => (ELLIPSOID_RADIAL, radii),
            Shape::Ellipsoid { radii, closest: true } => (ELLIPSOID, radii),
        };
        let norm = c.rotation.iter().map(|x| f64::from(*x).powi(2)).sum::<f64>().sqrt();
        let none = [T::of(0.0); 3];
        let solid = Solid {
            center: cast(c.center),
            kind,
            size: cast(size),
            friction: T::of(c.friction.into()),
            rotation: [T::of(0.0); 4],
            velocity: cast(c.velocity),
            spin: cast(c.spin),
            up: none,
            side: none,
            still: [c.velocity, c.spin].as_flattened().iter().all(|x| *x == 0.0),
        };
        solid.turned(cast(c.rotation.map(|x| f64::from(x) / norm)))
    }

    /// With another rotation.
    fn turned(self, rotation: [T; 4]) -> Self {
        let (zero, one) = (T::of(0.0), T::of(1.0));
        let (up, side) = (turn(rotation, [zero, one, zero]), turn(rotation, [one, zero, zero]));
        Solid { rotation, up, side, ..self }
    }

    /// With a coat of `by` \[m\]. That of a box has edges, and that of an ellipsoid is one too: both reach a little farther
    /// than `by` there, up to 1.73 times at the corners of a box.
    pub fn coated(&self, by: T) -> Self {
        if by == T::of(0.0) {
            return *self;
        }
        let [x, y, z] = self.size;
        match self.kind {
            HALF_SPACE => Solid { center: add(self.center, scale(self.up(), by)), ..*self },
            SPHERE | CAPSULE => Solid { size: [x + by, y, z], ..*self },
            TAPERED => Solid { size: [x + by, y, z + by], ..*self },
            _ => Solid { size: [x + by, y + by, z + by], ..*self },
        }
    }

    /// Itself `left` seconds earlier, by its velocity and spin.
    pub fn posed(&self, left: T) -> Self {
        let half = scale(self.spin, T::of(-0.5) * left);
        let ([x, y, z, w], axis) = (self.rotation, [self.rotation[0], self.rotation[1], self.rotation[2]]);
        let v = add(scale(half, w), cross(half, axis));
        let q = [x + v[0], y + v[1], z + v[2], w - dot(half, axis)];
        let by = T::of(1.0) / (q[0] * q[0] + q[1] * q[1] + q[2] * q[2] + q[3] * q[3]).sqrt();
        Solid { center: sub(self.center, scale(self.velocity, left)), ..self.turned(q.map(|x| x * by)) }
    }

    /// The way out for a point inside; none for a point outside.
    #[inline]
    pub fn exit(&self, p: V3<T>) -> Option<Exit<T>> {
        let d = sub(p, self.center);
        match self.kind {
            HALF_SPACE => self.half_space(p, d),
            SPHERE => ball(p, d, self.size[0], self.side),
            CAPSULE => {
                let y = dot(d, self.up).max(-self.size[1]).min(self.size[1]);
                ball(p, sub(d, scale(self.up, y)), self.size[0], self.side)
            }
            TAPERED => tapered(self, p, d),
            _ => {
                let [x, y, z, w] = self.rotation;
                let local = turn([-x, -y, -z, w], d);
                let (q, n) = match self.kind {
                    BOX => cuboid(local, self.size),
                    ELLIPSOID_RADIAL => radial(local, self.size),
                    _ => closest(local, self.size),
                }?;
                let way = sub(q, local);
                let at = add(turn(self.rotation, q), self.center);
                Some(Exit { at, normal: turn(self.rotation, n), depth: dot(way, way).sqrt() })
            }
        }
    }

    fn half_space(&self, p: V3<T>, d: V3<T>) -> Option<Exit<T>> {
        let depth = -dot(d, self.up);
        (depth > T::of(0.0)).then(|| Exit { at: add(p, scale(self.up, depth)), normal: self.up, depth })
    }
}

mod entry;
mod taper;
pub mod wide;

use taper::{Taper, tapered};

/// Rotates by a unit quaternion.
#[inline]
fn turn<T: Real>(q: [T; 4], v: V3<T>) -> V3<T> {
    let axis = [q[0], q[1], q[2]];
    let t = scale(cross(axis, v), T::of(2.0));
    add(add(v, scale(t, q[3])), cross(axis, t))
}

/// Out of a ball around the point that lies `d` from `p`; from its very centre to the side.
fn ball<T: Real>(p: V3<T>, d: V3<T>, radius: T, side: V3<T>) -> Option<Exit<T>> {
    let far2 = dot(d, d);
    if far2 >= radius * radius {
        return None;
    }
    let far = far2.sqrt();
    let normal = if far > T::of(1e-12) { scale(d, T::of(1.0) / far) } else { side };
    let depth = radius - far;
    Some(Exit { at: add(p, scale(normal, depth)), normal, depth })
}

/// Where a point in the frame of a solid leaves it, and the normal there.
type Local<T> = Option<(V3<T>, V3<T>)>;

fn cuboid<T: Real>(p: V3<T>, half: V3<T>) -> Local<T> {
    let depth = [0, 1, 2].map(|c| half[c] - p[c].abs());
    if depth.iter().any(|d| *d <= T::of(0.0)) {
        return None;
    }
    let axis = if depth[0] <= depth[1] && depth[0] <= depth[2] {
        0
    } else if depth[1] <= depth[2] {
        1
    } else {
        2
    };
    let sign = if p[axis] < T::of(0.0) { T::of(-1.0) } else { T::of(1.0) };
    let (mut q, mut n) = (p, [T::of(0.0); 3]);
    q[axis] = half[axis] * sign;
    n[axis] = sign;
    Some((q, n))
}

/// Along the ray from the centre.
fn radial<T: Real>(p: V3<T>, radii: V3<T>) -> Local<T> {
    let unit = [0, 1, 2].map(|c| p[c] / radii[c]);
    let (zero, one) = (T::of(0.0), T::of(1.0));
    let n = ball(unit, unit, one, [one, zero, zero])?.normal;
    let q = [0, 1, 2].map(|c| n[c] * radii[c]);
    Some((q, normalize([0, 1, 2].map(|c| n[c] / radii[c]))))
}

/// Newton steps; from the left of the root of a falling convex function they never pass it.
const STEPS: usize = 24;

/// To the closest point, after D. Eberly, "Distance from a Point to an Ellipse, an Ellipsoid, or a Hyperellipsoid":
/// q_c = r_c p_c / (t + r_c - 1), where r_c is the square of a radius over that of the smallest, and t in (0, 1] the root
/// of |q / radii| = 1. Writing t for his s + 1 keeps precision near the middle, where t is small.
fn closest<T: Real>(p: V3<T>, radii: V3<T>) -> Local<T> {
    let one = T::of(1.0);
    let z = [0, 1, 2].map(|c| p[c].abs() / radii[c]);
    if dot(z, z) >= one {
        return None;
    }
    let small = radii[0].min(radii[1]).min(radii[2]);
    let r = radii.map(|e| (e / small) * (e / small));
    let rz = [0, 1, 2].map(|c| if r[c] > one { z[c] } else { z[c].max(T::of(1e-7)) });
    let lowest = [0, 1, 2].map(|c| if r[c] > one { T::of(0.0) } else { rz[c] });
    let mut t = lowest[0].max(lowest[1]).max(lowest[2]);
    for _ in 0..STEPS {
        let (mut g, mut slope) = (-one, T::of(0.0));
        for c in 0..3 {
            let under = t + (r[c] - one);
            let a = r[c] * rz[c] / under;
            g = g + a * a;
            slope = slope + T::of(2.0) * a * a / under;
        }
        t = t + (g / slope).max(T::of(0.0));
    }
    let on = [0, 1, 2].map(|c| {
        let a = r[c] * rz[c] / (t + (r[c] - one));
        if p[c] < T::of(0.0) { -a } else { a }
    });
    // The remaining error of the root goes off along the ray.
    let n = normalize(on);
    let q = [0, 1, 2].map(|c| n[c] * radii[c]);
    Some((q, normalize([0, 1, 2].map(|c| n[c] / radii[c]))))
}

fn normalize<T: Real>(v: V3<T>) -> V3<T> {
    scale(v, T::of(1.0) / dot(v, v).sqrt())
}

#[cfg(test)]
#[path = "solid_tests.rs"]
mod tests;
