//! The way out of a solid for a vector of particles: the operations of [`Solid::exit`], in their order.

use super::{BOX, CAPSULE, ELLIPSOID_RADIAL, HALF_SPACE, SPHERE, STEPS, Solid, TAPERED, Taper};
use crate::number::lanes::Machine;
use crate::number::real::{Real, V3};

/// Vectors of numbers, of three coordinates.
pub type Wide<T, K> = [<K as Machine<T>>::V; 3];

/// The ways out, without meaning for points in the mask, which are outside.
pub struct Exits<T: Real, K: Machine<T>> {
    pub at: Wide<T, K>,
    pub normal: Wide<T, K>,
    pub depth: K::V,
    pub outside: K::M,
}

/// Where points in the frame of a solid leave it.
struct Locals<T: Real, K: Machine<T>> {
    at: Wide<T, K>,
    normal: Wide<T, K>,
    outside: K::M,
}

#[inline(always)]
pub fn splat<T: Real, K: Machine<T>>(k: K, v: V3<T>) -> Wide<T, K> {
    [k.splat(v[0]), k.splat(v[1]), k.splat(v[2])]
}

#[inline(always)]
pub fn add<T: Real, K: Machine<T>>(k: K, a: Wide<T, K>, b: Wide<T, K>) -> Wide<T, K> {
    [k.add(a[0], b[0]), k.add(a[1], b[1]), k.add(a[2], b[2])]
}

#[inline(always)]
pub fn sub<T: Real, K: Machine<T>>(k: K, a: Wide<T, K>, b: Wide<T, K>) -> Wide<T, K> {
    [k.sub(a[0], b[0]), k.sub(a[1], b[1]), k.sub(a[2], b[2])]
}

#[inline(always)]
pub fn scale<T: Real, K: Machine<T>>(k: K, a: Wide<T, K>, s: K::V) -> Wide<T, K> {
    [k.mul(a[0], s), k.mul(a[1], s), k.mul(a[2], s)]
}

#[inline(always)]
pub fn dot<T: Real, K: Machine<T>>(k: K, a: Wide<T, K>, b: Wide<T, K>) -> K::V {
    k.add(k.add(k.mul(a[0], b[0]), k.mul(a[1], b[1])), k.mul(a[2], b[2]))
}

#[inline(always)]
pub fn cross<T: Real, K: Machine<T>>(k: K, a: Wide<T, K>, b: Wide<T, K>) -> Wide<T, K> {
    let part = |m: usize, n: usize| k.sub(k.mul(a[m], b[n]), k.mul(a[n], b[m]));
    [part(1, 2), part(2, 0), part(0, 1)]
}

#[inline(always)]
pub fn choose<T: Real, K: Machine<T>>(k: K, mask: K::M, a: Wide<T, K>, b: Wide<T, K>) -> Wide<T, K> {
    [k.choose(mask, a[0], b[0]), k.choose(mask, a[1], b[1]), k.choose(mask, a[2], b[2])]
}

#[inline(always)]
fn turn<T: Real, K: Machine<T>>(k: K, [x, y, z, w]: [T; 4], v: Wide<T, K>) -> Wide<T, K> {
    let axis = splat(k, [x, y, z]);
    let t = scale(k, cross(k, axis, v), k.splat(T::of(2.0)));
    add(k, add(k, v, scale(k, t, k.splat(w))), cross(k, axis, t))
}

#[inline(always)]
fn abs<T: Real, K: Machine<T>>(k: K, x: K::V) -> K::V {
    let zero = k.splat(T::of(0.0));
    // The zero that is below zero becomes the other.
    k.choose(k.above(zero, x), k.mul(x, k.splat(T::of(-1.0))), k.add(x, zero))
}

#[inline(always)]
fn normalize<T: Real, K: Machine<T>>(k: K, v: Wide<T, K>) -> Wide<T, K> {
    scale(k, v, k.div(k.splat(T::of(1.0)), k.sqrt(dot(k, v, v))))
}

impl<T: Real> Solid<T> {
    /// [`Solid::exit`] of points without NaN.
    #[inline(always)]
    pub fn exits<K: Machine<T>>(&self, k: K, p: Wide<T, K>) -> Exits<T, K> {
        let (d, up) = (sub(k, p, splat(k, self.center)), splat(k, self.up));
        match self.kind {
            HALF_SPACE => {
                let zero = k.splat(T::of(0.0));
                let depth = k.sub(zero, dot(k, d, up));
                // A point that is not below is outside.
                let outside = k.without(k.at_least(zero, zero), k.above(depth, zero));
                Exits { at: add(k, p, scale(k, up, depth)), normal: up, depth, outside }
            }
            SPHERE => ball(k, p, d, k.splat(self.size[0]), splat(k, self.side)),
            CAPSULE => {
                let y = within(k, dot(k, d, up), self.size[1]);
                ball(k, p, sub(k, d, scale(k, up, y)), k.splat(self.size[0]), splat(k, self.side))
            }
            TAPERED => {
                let taper = Taper::new(self.size);
                let along = dot(k, d, up);
                let across = sub(k, d, scale(k, up, along));
                let beside = k.sqrt(dot(k, across, across));
                let y = within(k, k.sub(along, k.mul(beside, k.splat(taper.slope))), taper.half);
                let radius = k.add(k.splat(taper.middle), k.mul(y, k.splat(taper.rate)));
                ball(k, p, sub(k, d, scale(k, up, y)), radius, splat(k, taper.normal(self)))
            }
            _ => self.turned_exits(k, d),
        }
    }

    /// Those of a solid without an axis, from where points lie beside its middle.
    #[inline(always)]
    fn turned_exits<K: Machine<T>>(&self, k: K, d: Wide<T, K>) -> Exits<T, K> {
        let [x, y, z, w] = self.rotation;
        let local = turn(k, [-x, -y, -z, w], d);
        let Locals { at, normal, outside } = match self.kind {
            BOX => cuboid(k, local, self.size),
            ELLIPSOID_RADIAL => radial(k, local, self.size),
            _ => closest(k, local, self.size),
        };
        let way = sub(k, at, local);
        let at = add(k, turn(k, self.rotation, at), splat(k, self.center));
        Exits { at, normal: turn(k, self.rotation, normal), depth: k.sqrt(dot(k, way, way)), outside }
    }
}

/// Not beyond `half` on either side of 0.
#[inline(always)]
fn within<T: Real, K: Machine<T>>(k: K, y: K::V, half: T) -> K::V {
    let (low, high) = (k.splat(-half), k.splat(half));
    k.least(k.most(y, low), high)
}

#[inline(always)]
fn ball<T: Real, K: Machine<T>>(k: K, p: Wide<T, K>, d: Wide<T, K>, radius: K::V, side: Wide<T, K>) -> Exits<T, K> {
    let far2 = dot(k, d, d);
    let far = k.sqrt(far2);
    let away = k.above(far, k.splat(T::of(1e-12)));
    let normal = choose(k, away, scale(k, d, k.div(k.splat(T::of(1.0)), far)), side);
    let depth = k.sub(radius, far);
    Exits { at: add(k, p, scale(k, normal, depth)), normal, depth, outside: k.at_least(far2, k.mul(radius, radius)) }
}

#[inline(always)]
fn cuboid<T: Real, K: Machine<T>>(k: K, p: Wide<T, K>, half: V3<T>) -> Locals<T, K> {
    let (zero, one) = (k.splat(T::of(0.0)), k.splat(T::of(1.0)));
    let half = splat(k, half);
    let depth = sub(k, half, [abs(k, p[0]), abs(k, p[1]), abs(k, p[2])]);
    let first = k.both(k.at_least(depth[1], depth[0]), k.at_least(depth[2], depth[0]));
    let second = k.without(k.at_least(depth[2], depth[1]), first);
    let (mut at, mut normal) = (p, [zero; 3]);
    for c in 0..3 {
        let sign = k.choose(k.above(zero, p[c]), k.splat(T::of(-1.0)), one);
        let (face, plain) = (k.mul(half[c], sign), p[c]);
        (at[c], normal[c]) = match c {
            0 => (k.choose(first, face, plain), k.choose(first, sign, zero)),
            1 => (k.choose(second, face, plain), k.choose(second, sign, zero)),
            _ => {
                let rest = |a, b| k.choose(first, b, k.choose(second, b, a));
                (rest(face, plain), rest(sign, zero))
            }
        };
    }
    let all = k.at_least(zero, zero);
    let inside = depth.iter().fold(all, |inside, d| k.without(inside, k.at_least(zero, *d)));
    Locals { at, normal, outside: k.without(all, inside) }
}

#[inline(always)]
fn radial<T: Real, K: Machine<T>>(k: K, p: Wide<T, K>, radii: V3<T>) -> Locals<T, K> {
    let radii = splat(k, radii);
    let unit = over(k, p, radii);
    let (zero, one) = (k.splat(T::of(0.0)), k.splat(T::of(1.0)));
    let Exits { normal, outside, .. } = ball(k, unit, unit, one, [one, zero, zero]);
    Locals { at: times(k, normal, radii), normal: normalize(k, over(k, normal, radii)), outside }
}

#[inline(always)]
fn closest<T: Real, K: Machine<T>>(k: K, p: Wide<T, K>, radii: V3<T>) -> Locals<T, K> {
    let (zero, one) = (T::of(0.0), T::of(1.0));
    let small = radii[0].min(radii[1]).min(radii[2]);
    let r = radii.map(|e| (e / small) * (e / small));
    let radii = splat(k, radii);
    let z = over(k, [abs(k, p[0]), abs(k, p[1]), abs(k, p[2])], radii);
    let outside = k.at_least(dot(k, z, z), k.splat(one));
    let mut rz = z;
    let mut t = k.splat(zero);
    for c in (0..3).filter(|c| r[*c] <= one) {
        rz[c] = k.most(z[c], k.splat(T::of(1e-7)));
        t = k.most(rz[c], t);
    }
    let (more, r) = (splat(k, r.map(|r| r - one)), splat(k, r));
    let (none, two) = (k.splat(zero), k.splat(T::of(2.0)));
    for _ in 0..STEPS {
        let (mut g, mut slope) = (k.splat(-one), none);
        for c in 0..3 {
            let under = k.add(t, more[c]);
            let a = k.div(k.mul(r[c], rz[c]), under);
            g = k.add(g, k.mul(a, a));
            slope = k.add(slope, k.div(k.mul(k.mul(two, a), a), under));
        }
        t = k.add(t, k.most(k.div(g, slope), none));
    }
    let mut on = p;
    for c in 0..3 {
        let a = k.div(k.mul(r[c], rz[c]), k.add(t, more[c]));
        on[c] = k.choose(k.above(none, p[c]), k.mul(a, k.splat(-one)), a);
    }
    let n = normalize(k, on);
    Locals { at: times(k, n, radii), normal: normalize(k, over(k, n, radii)), outside }
}

#[inline(always)]
fn over<T: Real, K: Machine<T>>(k: K, a: Wide<T, K>, b: Wide<T, K>) -> Wide<T, K> {
    [k.div(a[0], b[0]), k.div(a[1], b[1]), k.div(a[2], b[2])]
}

#[inline(always)]
fn times<T: Real, K: Machine<T>>(k: K, a: Wide<T, K>, b: Wide<T, K>) -> Wide<T, K> {
    [k.mul(a[0], b[0]), k.mul(a[1], b[1]), k.mul(a[2], b[2])]
}
