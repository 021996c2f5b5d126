//! Where a path enters a solid, and how far a solid reaches.

use super::{BOX, CAPSULE, HALF_SPACE, SPHERE, Solid, TAPERED, add, dot, normalize, scale, sub, taper, turn};
use crate::number::real::{Real, V3};

impl<T: Real> Solid<T> {
    /// Where the path `from + t path`, t in 0..=1, first meets the surface, and the normal there. Of a start inside
    /// nothing is said.
    pub fn entry(&self, from: V3<T>, path: V3<T>) -> Option<(V3<T>, V3<T>)> {
        let [x, y, z, w] = self.rotation;
        let back = [-x, -y, -z, w];
        let (o, d) = (turn(back, sub(from, self.center)), turn(back, path));
        let zero = T::of(0.0);
        let (t, n) = match self.kind {
            HALF_SPACE => (o[1] > zero && d[1] < zero).then(|| (o[1] / -d[1], [zero, T::of(1.0), zero])),
            SPHERE => sphere(o, d, [zero; 3], self.size[0]),
            CAPSULE => capsule(o, d, self.size[0], self.size[1]),
            TAPERED => taper::side(o, d, self.size).or_else(|| {
                let [low, half, high] = self.size;
                first([(half, high), (-half, low)].map(|(y, radius)| sphere(o, d, [zero, y, zero], radius)))
            }),
            BOX => cuboid(o, d, self.size),
            _ => {
                let over = |v: V3<T>| [0, 1, 2].map(|c| v[c] / self.size[c]);
                let hit = sphere(over(o), over(d), [zero; 3], T::of(1.0));
                hit.map(|(t, n)| (t, normalize(over(n))))
            }
        }?;
        (t <= T::of(1.0)).then(|| (add(from, scale(path, t)), turn(self.rotation, n)))
    }

    /// The smallest distance \[m\] through the middle; a half-space has no other side.
    pub fn thickness(&self) -> T {
        let s = self.size;
        match self.kind {
            HALF_SPACE => T::of(1e18),
            SPHERE | CAPSULE => s[0],
            TAPERED => s[0].min(s[2]),
            _ => s[0].min(s[1]).min(s[2]),
        }
    }

    /// Radius \[m\] of a ball around it; none for a half-space.
    pub fn around(&self) -> Option<T> {
        let s = self.size;
        match self.kind {
            HALF_SPACE => None,
            SPHERE => Some(s[0]),
            CAPSULE => Some(s[0] + s[1]),
            TAPERED => Some(s[0].max(s[2]) + s[1]),
            BOX => Some(dot(s, s).sqrt()),
            _ => Some(s[0].max(s[1]).max(s[2])),
        }
    }

    /// Half the length of the segment along its y axis that all of it is near, and the largest distance \[m\] from that; none of shapes without
    /// such a segment.
    pub fn line(&self) -> Option<[T; 2]> {
        let [x, y, z] = self.size;
        match self.kind {
            CAPSULE => Some([y, x]),
            TAPERED => Some([y, x.max(z)]),
            _ => None,
        }
    }

    /// Its y axis in the world: the normal of a half-space.
    pub fn up(&self) -> V3<T> {
        self.up
    }

    /// Its axes in the world.
    pub fn axes(&self) -> [V3<T>; 3] {
        let (zero, one) = (T::of(0.0), T::of(1.0));
        [[one, zero, zero], [zero, one, zero], [zero, zero, one]].map(|axis| turn(self.rotation, axis))
    }
}

type Hit<T> = Option<(T, V3<T>)>;

fn sphere<T: Real>(o: V3<T>, d: V3<T>, center: V3<T>, radius: T) -> Hit<T> {
    let m = sub(o, center);
    let (a, b, c) = (dot(d, d), dot(m, d), dot(m, m) - radius * radius);
    let zero = T::of(0.0);
    if c <= zero || b >= zero || a <= zero {
        return None;
    }
    let under = b * b - a * c;
    if under < zero {
        return None;
    }
    let t = (-b - under.sqrt()) / a;
    Some((t, normalize(add(m, scale(d, t)))))
}

/// The side, else one of the caps.
fn capsule<T: Real>(o: V3<T>, d: V3<T>, radius: T, half: T) -> Hit<T> {
    let zero = T::of(0.0);
    let (a, b) = (d[0] * d[0] + d[2] * d[2], o[0] * d[0] + o[2] * d[2]);
    let c = o[0] * o[0] + o[2] * o[2] - radius * radius;
    let under = b * b - a * c;
    if a > zero && c > zero && b < zero && under >= zero {
        let t = (-b - under.sqrt()) / a;
        let y = o[1] + d[1] * t;
        if y.abs() <= half {
            return Some((t, normalize([o[0] + d[0] * t, zero, o[2] + d[2] * t])));
        }
    }
    first([half, -half].map(|y| sphere(o, d, [zero, y, zero], radius)))
}

/// The one that is met first.
fn first<T: Real>(hits: [Hit<T>; 2]) -> Hit<T> {
    match hits {
        [Some(a), Some(b)] => Some(if a.0 < b.0 { a } else { b }),
        [a, b] => a.or(b),
    }
}

/// By slabs.
fn cuboid<T: Real>(o: V3<T>, d: V3<T>, half: V3<T>) -> Hit<T> {
    let (zero, far) = (T::of(0.0), T::of(f64::from(f32::MAX)));
    let (mut enter, mut leave, mut axis) = (-far, far, None);
    for c in 0..3 {
        if d[c] == zero {
            if o[c].abs() > half[c] {
                return None;
            }
            continue;
        }
        let (a, b) = ((-half[c] - o[c]) / d[c], (half[c] - o[c]) / d[c]);
        if a.min(b) > enter {
            (enter, axis) = (a.min(b), Some(c));
        }
        leave = leave.min(a.max(b));
    }
    let axis = axis.filter(|_| enter <= leave && enter >= zero)?;
    let mut n = [zero; 3];
    n[axis] = if d[axis] > zero { T::of(-1.0) } else { T::of(1.0) };
    Some((enter, n))
}
