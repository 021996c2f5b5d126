//! Effect of a spring on its ends, for as many springs at once as the machine has lanes.

use super::{ALIKE, ALIKE_BOUND, DIAGONAL, End, HARD, HARD_BOUND, LIMIT, RIGHT, SOFT, Spring};
use crate::cpu::aside;
use crate::cpu::sheet::Values;
use crate::number::lanes::{LANES, Machine};
use crate::number::real::Real;

/// A diagonal that has a bound draws its ends together by no more than that, but what is longer by this share of its length
/// is drawn together to there at once.
///
/// Where folds cross, cloth that bends along the sides of its cells alone cannot keep all lengths, and gravity is too weak
/// to undo it: sides stay 5 to 14 % too long forever. Real cloth folds along diagonals there, and shears before it
/// stretches. So the force of diagonals ends somewhere, far above what cloth that hangs or lies asks of them.
pub const TORN: f64 = 0.25;

impl<T: Real> Spring<'_, T> {
    /// Relaxes `count` springs from `a` to `b`, whose lengths are stored from `stored` on.
    #[inline(always)]
    pub(super) fn relax<K: Machine<T>, const KIND: u8, const WAY: u8>(
        &self,
        k: K,
        a: End<T>,
        b: End<T>,
        stored: usize,
        count: usize,
        sums: &mut [T],
    ) {
        match KIND {
            ALIKE => self.equals::<K, false, WAY>(k, [a.at, b.at], stored, count),
            ALIKE_BOUND => self.equals::<K, true, WAY>(k, [a.at, b.at], stored, count),
            HARD => self.list::<K, HARD, WAY>(k, a, b, stored, count, sums),
            HARD_BOUND => self.list::<K, HARD_BOUND, WAY>(k, a, b, stored, count, sums),
            LIMIT => self.list::<K, LIMIT, WAY>(k, a, b, stored, count, sums),
            _ => self.list::<K, SOFT, WAY>(k, a, b, stored, count, sums),
        }
    }

    #[inline(always)]
    fn list<K: Machine<T>, const KIND: u8, const WAY: u8>(
        &self,
        k: K,
        a: End<T>,
        b: End<T>,
        stored: usize,
        count: usize,
        sums: &mut [T],
    ) {
        let (zero, closest, least) = (k.splat(T::of(0.0)), k.splat(T::of(1e-9)), k.splat(T::of(1e-30)));
        let times = k.splat(self.times);
        let (span, short) = (k.splat(self.span), k.splat(T::of(aside::SHORT)));
        // All as long, so that this is checked once.
        let long = count.next_multiple_of(K::WIDE);
        let [ax, ay, az] = a.at.map(|p| &mut p[..long]);
        let [bx, by, bz] = b.at.map(|p| &mut p[..long]);
        let (was, wbs, rests) = (&a.w[..long], &b.w[..long], self.rest.of(stored, count, long));
        for at in (0..long).step_by(K::WIDE) {
            let p = [k.load(ax, at), k.load(ay, at), k.load(az, at)];
            let q = [k.load(bx, at), k.load(by, at), k.load(bz, at)];
            let (wa, wb) = (k.load(was, at), k.load(wbs, at));
            let rest = k.load(rests, at);
            let mut d = [k.sub(q[0], p[0]), k.sub(q[1], p[1]), k.sub(q[2], p[2])];
            let mut far = k.most(k.sqrt(k.squares(d)), closest);
            if WAY == RIGHT && KIND != LIMIT && k.any(k.above(k.mul(rest, short), far)) {
                (d, far) = self.turned(k, d, rest, far, stored + at);
            }
            let (mut over, w) = (k.sub(far, rest), k.add(wa, wb));
            if WAY == DIAGONAL && KIND == HARD_BOUND {
                over = self.within(k, over, rest);
            }
            let mut g = if KIND != SOFT {
                k.div(over, k.most(k.mul(far, w), least))
            } else {
                let soft = k.div(value(k, self.soft, stored + at), span);
                let over = if sums.is_empty() { over } else { k.sub(over, k.mul(soft, k.load(sums, at))) };
                k.div(over, k.most(k.mul(far, k.add(w, soft)), least))
            };
            g = k.choose(k.above(rest, zero), g, zero);
            if WAY != DIAGONAL && (KIND == HARD || KIND == HARD_BOUND) {
                g = k.mul(g, times);
            }
            if KIND == LIMIT {
                g = k.choose(k.above(g, zero), g, zero);
            }
            if KIND == SOFT && !sums.is_empty() {
                let sum = k.add(k.load(sums, at), k.mul(g, far));
                k.store(sums, at, sum);
            }
            let (ga, gb) = (k.mul(g, wa), k.mul(g, wb));
            k.store(ax, at, k.add(p[0], k.mul(d[0], ga)));
            k.store(ay, at, k.add(p[1], k.mul(d[1], ga)));
            k.store(az, at, k.add(p[2], k.mul(d[2], ga)));
            k.store(bx, at, k.sub(q[0], k.mul(d[0], gb)));
            k.store(by, at, k.sub(q[1], k.mul(d[1], gb)));
            k.store(bz, at, k.sub(q[2], k.mul(d[2], gb)));
        }
    }
}

impl<T: Real> Spring<'_, T> {
    /// Hard springs between particles of one mass: each end takes half of the error, whatever the mass is. Neither roots nor
    /// divisions are needed.
    #[inline(always)]
    fn equals<K: Machine<T>, const BOUND: bool, const WAY: u8>(
        &self,
        k: K,
        [a, b]: [[&mut [T]; 3]; 2],
        stored: usize,
        count: usize,
    ) {
        let (zero, half, closest) = (k.splat(T::of(0.0)), k.splat(T::of(0.5)), k.splat(T::of(1e-9)));
        let (short, times) = (k.splat(T::of(aside::SHORT)), k.splat(self.times));
        let long = count.next_multiple_of(K::WIDE);
        let ([ax, ay, az], [bx, by, bz]) = (a, b);
        let (ax, ay, az) = (&mut ax[..long], &mut ay[..long], &mut az[..long]);
        let (bx, by, bz) = (&mut bx[..long], &mut by[..long], &mut bz[..long]);
        let rests = self.rest.of(stored, count, long);
        for at in (0..long).step_by(K::WIDE) {
            let p = [k.load(ax, at), k.load(ay, at), k.load(az, at)];
            let q = [k.load(bx, at), k.load(by, at), k.load(bz, at)];
            let mut d = [k.sub(q[0], p[0]), k.sub(q[1], p[1]), k.sub(q[2], p[2])];
            let mut far = k.most(k.sqrt(k.squares(d)), closest);
            let rest = k.load(rests, at);
            if WAY == RIGHT && k.any(k.above(k.mul(rest, short), far)) {
                (d, far) = self.turned(k, d, rest, far, stored + at);
            }
            let share = k.div(k.mul(half, rest), far);
            let mut g = k.sub(half, share);
            if WAY != DIAGONAL {
                g = k.mul(g, times);
            }
            if BOUND && WAY == DIAGONAL {
                g = self.within(k, g, share);
            }
            let g = k.choose(k.above(rest, zero), g, zero);
            let m = [k.mul(d[0], g), k.mul(d[1], g), k.mul(d[2], g)];
            k.store(ax, at, k.add(p[0], m[0]));
            k.store(ay, at, k.add(p[1], m[1]));
            k.store(az, at, k.add(p[2], m[2]));
            k.store(bx, at, k.sub(q[0], m[0]));
            k.store(by, at, k.sub(q[1], m[1]));
            k.store(bz, at, k.sub(q[2], m[2]));
        }
    }

    /// Errors of diagonals within their bound, or within a quarter of a length that is too long; `whole` is all of a length.
    #[inline(always)]
    fn within<K: Machine<T>>(&self, k: K, error: K::V, whole: K::V) -> K::V {
        let bound = k.mul(whole, k.splat(self.bound));
        let most = k.most(k.sub(error, k.mul(whole, k.splat(T::of(TORN)))), bound);
        let least = k.sub(k.splat(T::of(0.0)), bound);
        k.most(least, k.least(most, error))
    }

    /// Vectors and lengths of springs to the right, some of which have almost no length, as [`aside`] has them.
    #[inline(always)]
    fn turned<K: Machine<T>>(&self, k: K, d: [K::V; 3], rest: K::V, far: K::V, stored: usize) -> ([K::V; 3], K::V) {
        let mut lists = [d[0], d[1], d[2], rest, far].map(|v| {
            let mut list = [T::of(0.0); LANES];
            k.store(&mut list, 0, v);
            list
        });
        self.push_aside(&mut lists, stored);
        let d = [k.load(&lists[0], 0), k.load(&lists[1], 0), k.load(&lists[2], 0)];
        (d, k.most(k.sqrt(k.squares(d)), k.splat(T::of(1e-9))))
    }

    /// Turns the vectors of springs to the right that have almost no length; the first of them is stored at `stored`. Of a list the
    /// numbers past the vector are zeros: no springs.
    #[cold]
    #[inline(never)]
    fn push_aside(&self, [x, y, z, rest, far]: &mut [[T; LANES]; 5], stored: usize) {
        let width = self.columns[0] + self.columns[1];
        for n in (0..LANES).filter(|n| far[*n] < rest[*n] * T::of(aside::SHORT)) {
            let (row, place) = ((stored + n) / (2 * self.half), (stored + n) % (2 * self.half));
            let column = 2 * (place % self.half) + place / self.half;
            let by = rest[n] * T::of(aside::ASIDE);
            let way = aside::way::<T>((row * width + column) as u32);
            (x[n], y[n], z[n]) = (x[n] + way[0] * by, y[n] + way[1] * by, z[n] + way[2] * by);
        }
    }
}

#[inline(always)]
fn value<T: Real, K: Machine<T>>(k: K, values: &Values<T>, at: usize) -> K::V {
    match values {
        Values::Constant(x) => k.splat(*x),
        Values::List(list) => k.load(list, at),
    }
}
