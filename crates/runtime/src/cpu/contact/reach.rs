//! The part of a sheet that colliders can touch within a step.

use super::super::sheet::{Sheet, planes_ref};
use crate::collider::solid::Solid;
use crate::number::lanes::{LANES, Machine, Work, widest};
use crate::number::real::{Real, V3, dot, sub};

/// A ball or a half-space around all that a solid can touch within a step.
pub struct Reach<T> {
    center: V3<T>,
    /// Squared radius; none for a half-space.
    radius: Option<T>,
    normal: V3<T>,
    /// Of a capsule, tapered or not, which is much smaller than the ball around it.
    line: Option<Line<T>>,
    /// How far its surface can move in a step \[m\]; infinite for a half-space that turns.
    moves: T,
    /// The square of a distance \[m^2\] within which all points inside are, from the center or the line.
    inside2: T,
    /// The square of a way \[m^2\]: a particle that goes at most as far goes a short way, if it is near. Below 0 if none does.
    calm2: T,
}

/// A line and the distance from it within which a solid can touch.
struct Line<T> {
    /// A unit vector.
    axis: V3<T>,
    half: T,
    radius: T,
}

impl<T: Real> Reach<T> {
    pub fn new(solid: &Solid<T>, dt: T) -> Self {
        let around = solid.around();
        let v = solid.velocity;
        let moves = dot(v, v).sqrt() * dt;
        let s = solid.spin;
        let farther = |r: T| moves + dot(s, s).sqrt() * dt * r;
        let radius = around.map(|r| r + farther(r));
        let normal = solid.up();
        let size = |v: V3<T>| v[0].abs() + v[1].abs() + v[2].abs();
        // Above all rounding, as in `may`.
        let slack = |r: T| T::of(1e-5) * (size(solid.center) + r);
        let line = around.zip(solid.line()).map(|(r, [half, thick])| Line {
            axis: normal,
            half,
            radius: (thick + farther(r)) * T::of(1.001) + slack(r),
        });
        let inside = around.map_or(T::of(0.0), |r| {
            let own = solid.line().map_or(r, |[_, thick]| thick);
            own * T::of(1.001) + slack(r)
        });
        let turns = if around.is_none() && dot(s, s) > T::of(0.0) { T::of(f64::INFINITY) } else { T::of(0.0) };
        let moves = around.map_or(moves + turns, farther) * T::of(1.01);
        // A near particle was at most its way and what the surface moves farther from the center than the surface.
        let turn = T::of(1.0) + T::of(2.0) * dot(s, s).sqrt() * dt;
        let calm = solid.thickness() * T::of(0.24) / turn - moves;
        let calm2 = if calm > T::of(0.0) { calm * calm } else { T::of(-1.0) };
        Reach { center: solid.center, radius, normal, line, moves, inside2: inside * inside, calm2 }
    }

    pub fn box_near(&self, lowest: V3<T>, highest: V3<T>) -> bool {
        let zero = T::of(0.0);
        match self.radius {
            Some(r) => {
                let d = [0, 1, 2].map(|c| (lowest[c] - self.center[c]).max(self.center[c] - highest[c]).max(zero));
                dot(d, d) <= r * r
            }
            None => {
                let corner = [0, 1, 2].map(|c| if self.normal[c] > zero { lowest[c] } else { highest[c] });
                dot(sub(corner, self.center), self.normal) <= zero
            }
        }
    }

    /// A box around where particles in a box can be pushed to.
    pub fn pushes(&self, lowest: V3<T>, highest: V3<T>) -> (V3<T>, V3<T>) {
        match self.radius {
            // To its surface, and by friction along that.
            Some(r) => [-r, r].map(|r| [0, 1, 2].map(|c| self.center[c] + T::of(2.0) * r)).into(),
            None => {
                let corner = [0, 1, 2].map(|c| if self.normal[c] > T::of(0.0) { lowest[c] } else { highest[c] });
                let deep = dot(sub(self.center, corner), self.normal).max(T::of(0.0));
                (lowest.map(|x| x - deep), highest.map(|x| x + deep))
            }
        }
    }

    /// Whether a particle that went from `was` to `p` can touch it. Above all rounding, by a share of what is rounded, so
    /// that what is left out would not have moved.
    pub fn may(&self, p: V3<T>, was: V3<T>) -> bool {
        let Some(r) = self.radius else { return true };
        let (d, way) = (sub(p, self.center), sub(p, was));
        let size = |v: V3<T>| v[0].abs() + v[1].abs() + v[2].abs();
        let slack = T::of(1e-5) * (size(p) + size(was) + size(self.center));
        let reach = (r + dot(way, way).sqrt()) * T::of(1.001) + slack;
        // NaN is left to the rule.
        let far = dot(d, d).sqrt() > reach;
        !far
    }

    /// The middle, the direction and half the length of a line, and the distance \[m\] from it within which the solid can touch; a line
    /// of length 0 for a ball, and the largest distance for a half-space.
    pub fn line(&self) -> (V3<T>, V3<T>, T, T) {
        let zero = T::of(0.0);
        match (self.radius, &self.line) {
            (None, _) => (self.center, [zero; 3], zero, T::of(f64::from(f32::MAX))),
            (Some(radius), None) => (self.center, [zero; 3], zero, radius),
            (_, Some(line)) => (self.center, line.axis, line.half, line.radius),
        }
    }

    /// How far its surface can move in a step \[m\].
    pub fn moves(&self) -> T {
        self.moves
    }

    /// The largest coordinate that its distances are computed from.
    pub fn size(&self) -> T {
        let [x, y, z] = self.center.map(T::abs);
        x.max(y).max(z) + self.radius.unwrap_or(T::of(0.0))
    }

    /// How far the particles at `p` are from what it can touch, and those that come near on their way, given its squared length: the
    /// ball around the way meets that of the solid. The others would not have moved.
    #[inline(always)]
    pub fn near<K: Machine<T>>(&self, k: K, p: [K::V; 3], way2: K::V) -> (K::V, K::M) {
        match self.apart_by(k, p) {
            Ok((far2, r)) => {
                let (way, far, r) = (k.sqrt(way2), k.sqrt(far2), k.splat(r));
                // Written so that NaN is not near: nothing can be done for it.
                (k.sub(far, r), k.above(k.add(r, way), far))
            }
            Err(above) => (above, k.above(k.splat(T::of(0.0)), above)),
        }
    }

    /// The free particles that are near by [`Reach::near`], or by rounding, given the squares of their ways, and whether any of them may
    /// move; without meaning if none may. After a short way only particles inside move.
    #[inline(always)]
    pub fn touches<K: Machine<T>>(&self, k: K, p: [K::V; 3], way2: K::V, free: K::M) -> (K::M, bool) {
        match self.apart_by(k, p) {
            Ok((far2, r)) => {
                let inside = k.any(k.both(free, k.above(k.splat(self.inside2), far2)));
                let long = k.both(free, k.above(way2, k.splat(self.calm2)));
                // One branch for both: a processor does not foresee which colliders of a list are touched.
                if !(inside | k.any(long)) {
                    return (long, false);
                }
                let way = k.mul(k.sqrt(way2), k.splat(T::of(1.001)));
                let reach = k.add(k.splat(r * T::of(1.00001)), way);
                let near = k.both(free, k.above(k.mul(reach, reach), far2));
                (near, inside || k.any(k.both(near, long)))
            }
            Err(above) => {
                let near = k.both(free, k.above(k.splat(T::of(0.0)), above));
                (near, k.any(near))
            }
        }
    }

    /// Squared distances from the center or the line, and the distance within which it can touch; of a half-space the heights above it.
    #[inline(always)]
    fn apart_by<K: Machine<T>>(&self, k: K, p: [K::V; 3]) -> Result<(K::V, T), K::V> {
        let d = k.minus(p, k.splats(self.center));
        match (self.radius, &self.line) {
            (None, _) => Err(k.dot(d, k.splats(self.normal))),
            (Some(r), None) => Ok((k.squares(d), r)),
            (Some(_), Some(line)) => Ok((k.squares(line.across(k, d)), line.radius)),
        }
    }
}

impl<T: Real> Line<T> {
    /// From the nearest point of the line; `d` is from its middle.
    #[inline(always)]
    fn across<K: Machine<T>>(&self, k: K, d: [K::V; 3]) -> [K::V; 3] {
        let [x, y, z] = self.axis;
        // Three lines instead of a closure: the compiler does not inline closures over vectors here.
        let axis = [k.splat(x), k.splat(y), k.splat(z)];
        let along = k.add(k.add(k.mul(d[0], axis[0]), k.mul(d[1], axis[1])), k.mul(d[2], axis[2]));
        let (low, high) = (k.splat(-self.half), k.splat(self.half));
        let along = k.least(k.most(along, low), high);
        [k.sub(d[0], k.mul(axis[0], along)), k.sub(d[1], k.mul(axis[1], along)), k.sub(d[2], k.mul(axis[2], along))]
    }
}

/// The box around all free particles now and before.
pub fn bounds<T: Real>(sheet: &Sheet<T>) -> (V3<T>, V3<T>) {
    let mut out = [[T::of(0.0); 3]; 2];
    widest(Bounds { sheet, out: &mut out });
    (out[0], out[1])
}

struct Bounds<'a, T: Real> {
    sheet: &'a Sheet<T>,
    out: &'a mut [V3<T>; 2],
}

impl<T: Real> Work<T> for Bounds<'_, T> {
    #[inline(always)]
    fn run<K: Machine<T>>(self, k: K) {
        let (half, row) = (self.sheet.half, self.sheet.row());
        let most = T::of(f64::from(f32::MAX));
        let (zero, none, lowest) = (k.splat(T::of(0.0)), k.splat(most), k.splat(-most));
        let (mut low, mut high) = ([none; 3], [lowest; 3]);
        let rows = self.sheet.now.chunks_exact(row).zip(self.sheet.before.chunks_exact(row));
        for ((now, before), w) in rows.zip(self.sheet.w.chunks_exact(2 * half)) {
            let (now, before) = (planes_ref(now, half), planes_ref(before, half));
            for at in (0..2 * half).step_by(K::WIDE) {
                let free = k.above(k.load(w, at), zero);
                for c in 0..3 {
                    let (x, was) = (k.load(now[c], at), k.load(before[c], at));
                    // NaN is left out.
                    low[c] = k.choose(free, k.least(was, k.least(x, low[c])), low[c]);
                    high[c] = k.choose(free, k.most(was, k.most(x, high[c])), high[c]);
                }
            }
        }
        for c in 0..3 {
            let mut lanes = [[T::of(0.0); LANES]; 2];
            k.store(&mut lanes[0], 0, low[c]);
            k.store(&mut lanes[1], 0, high[c]);
            self.out[0][c] = lanes[0][..K::WIDE].iter().copied().fold(most, T::min);
            self.out[1][c] = lanes[1][..K::WIDE].iter().copied().fold(-most, T::max);
        }
    }
}
