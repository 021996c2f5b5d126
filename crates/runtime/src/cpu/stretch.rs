//! Twin of shaders/stretch.wgsl: springs of one direction and parity, with compliance.

use super::aside;
use super::lanes::{LANES, Machine, Work, widest};
use super::real::Real;
use super::rows::Threads;
use super::sheet::{Sheet, Values, planes};

/// The springs of one direction.
pub struct Springs<T> {
    /// Rest lengths \[m\]; 0 is no spring.
    pub rest: Values<T>,
    /// Compliance \[m/N\].
    pub soft: Values<T>,
    /// Sums of multipliers of this step; empty until there is more than one relaxation and any compliance.
    pub sums: Vec<T>,
    /// Share of its rest length by which a hard diagonal may move its ends; 0 is no bound. It depends on the step.
    pub bound: T,
}

impl<T: Real> Springs<T> {
    /// Whether they do not give.
    pub fn are_hard(&self) -> bool {
        matches!(self.soft, Values::Constant(x) if x == T::of(0.0))
    }
}

/// Relaxes the springs of a colour, direction and parity, once. `again` says whether it is done several times a step of
/// `dt` \[s\].
///
/// A spring of length l moves its ends along itself by w g, g = (l - rest - a s) / (w1 + w2 + a), a = compliance / dt^2,
/// s the sum of the g of earlier relaxations of this step (Macklin, Mueller, Chentanez, "XPBD", MIG 2016).
pub fn run<T: Real>(
    threads: &Threads,
    sheet: &mut Sheet<T>,
    springs: &mut Springs<T>,
    colour: (u32, u32),
    again: bool,
    dt: T,
) {
    let kind = if springs.are_hard() { Kind::Hard } else { Kind::Soft { again } };
    run_colour(threads, sheet, springs, colour, kind, dt * dt);
}

/// As [`run`] with springs that only hold ends together: the rest lengths are the longest allowed.
pub fn limit<T: Real>(threads: &Threads, sheet: &mut Sheet<T>, springs: &mut Springs<T>, direction: u32, parity: u32) {
    run_colour(threads, sheet, springs, (direction, parity), Kind::Limit, T::of(1.0));
}

/// A diagonal that has a bound draws its ends together by no more than that, but what is longer by this share of its length
/// is drawn together to there at once.
///
/// Where folds cross, cloth that bends along the sides of its cells alone cannot keep all lengths, and gravity is too weak
/// to undo it: sides stay 5 to 14 % too long for ever. Real cloth folds along diagonals there, and shears before it
/// stretches. So the force of diagonals ends somewhere, far above what cloth that hangs or lies asks of them.
pub const TORN: f64 = 0.25;

/// A bound of diagonals that none reaches.
pub const UNBOUNDED: f64 = 1e30;

/// The kinds as numbers, the first of them between particles of one mass.
const ALIKE: u8 = 0;
const HARD: u8 = 1;
const SOFT: u8 = 2;
const LIMIT: u8 = 3;
/// The first two where diagonals have a bound.
const ALIKE_BOUND: u8 = 4;
const HARD_BOUND: u8 = 5;

/// The ways that springs go.
const RIGHT: u8 = 0;
const DOWN: u8 = 1;
const DIAGONAL: u8 = 2;

#[derive(Clone, Copy)]
enum Kind {
    Hard,
    Soft { again: bool },
    Limit,
}

fn run_colour<T: Real>(
    threads: &Threads,
    sheet: &mut Sheet<T>,
    springs: &mut Springs<T>,
    (direction, parity): (u32, u32),
    kind: Kind,
    span: T,
) {
    let (width, half, row) = (sheet.width, sheet.half, sheet.row());
    let (w, alike) = (&sheet.w[..], &sheet.alike[..]);
    let mut sums = std::mem::take(&mut springs.sums);
    let spring = Spring { span, kind, ..Spring::of((width, half), alike, springs) };
    let parity = parity as usize;
    let (first, step) = if direction == 0 { (0, 1) } else { (parity, 2) };
    let size = TOGETHER / step * step;
    let rows = &mut sheet.now[first * row..];
    let work = |chunk: usize, rows: &mut [T], sums: &mut [T]| {
        let first = first + chunk * size;
        widest(Rows { spring: &spring, rows, sums, w, first, step, row, colour: (direction, parity) });
    };
    match kind {
        Kind::Soft { again: true } => {
            threads.chunks2(rows, &mut sums[first * 2 * half..], (size * row, size * 2 * half), work)
        }
        _ => threads.chunks(rows, size * row, |chunk, rows| work(chunk, rows, &mut [])),
    }
    springs.sums = sums;
}

/// Rows that are done in one go.
const TOGETHER: usize = 32;

/// The springs of a direction.
pub struct Spring<'a, T> {
    rest: &'a Values<T>,
    soft: &'a Values<T>,
    half: usize,
    /// As [`Sheet::alike`].
    alike: &'a [T],
    /// Square of the step \[s^2\].
    span: T,
    kind: Kind,
    bound: T,
    /// Even columns, pairs from even to odd, pairs from odd to even.
    columns: [usize; 3],
}

/// Rows whose springs share no particle with those of other rows.
struct Rows<'a, 'b, T> {
    spring: &'a Spring<'a, T>,
    rows: &'b mut [T],
    sums: &'b mut [T],
    w: &'a [T],
    first: usize,
    /// Rows that belong together, 1 or 2.
    step: usize,
    /// Numbers in a row.
    row: usize,
    colour: (u32, usize),
}

impl<T: Real> Work<T> for Rows<'_, '_, T> {
    #[inline(always)]
    fn run<K: Machine<T>>(self, k: K) {
        for (n, rows) in self.rows.chunks_exact_mut(self.step * self.row).enumerate() {
            let sums = self.sums.get_mut(n * self.step * 2 * self.spring.half..).unwrap_or(&mut []);
            self.spring.rows(k, rows, self.w, self.first + n * self.step, self.colour, sums);
        }
    }
}

/// One end of a list of springs.
struct End<'a, T> {
    at: [&'a mut [T]; 3],
    w: &'a [T],
}

impl<'a, T: Real> Spring<'a, T> {
    /// Hard ones, of a sheet of so many columns and numbers in half a row.
    pub fn of((width, half): (usize, usize), alike: &'a [T], springs: &'a Springs<T>) -> Self {
        let columns = [width.div_ceil(2), width / 2, (width - 1) / 2];
        let Springs { rest, soft, bound, .. } = springs;
        Spring { rest, soft, half, alike, span: T::of(1.0), kind: Kind::Hard, bound: *bound, columns }
    }

    /// For the code of those that have a bound: one that nothing reaches where there is none.
    pub fn bounded(self) -> Self {
        let bound = if self.bound > T::of(0.0) { self.bound } else { T::of(UNBOUNDED) };
        Spring { bound, ..self }
    }

    /// As [`Spring::rows`] where they are hard.
    #[inline(always)]
    pub fn hard<K: Machine<T>, const BOUND: bool>(
        &self,
        k: K,
        rows: &mut [T],
        w: &[T],
        j: usize,
        colour: (u32, usize),
    ) {
        match (self.alike(j, colour.0), BOUND) {
            (true, false) => self.colour::<K, ALIKE>(k, rows, w, j, colour, &mut []),
            (true, true) => self.colour::<K, ALIKE_BOUND>(k, rows, w, j, colour, &mut []),
            (false, false) => self.colour::<K, HARD>(k, rows, w, j, colour, &mut []),
            (false, true) => self.colour::<K, HARD_BOUND>(k, rows, w, j, colour, &mut []),
        }
    }

    /// Whether the ends of all springs from row `j` on have one mass.
    #[inline(always)]
    fn alike(&self, j: usize, direction: u32) -> bool {
        self.alike[j] > T::of(0.0) && self.alike[j] == self.alike[j + usize::from(direction > 0)]
    }

    /// Relaxes the springs of a row, or of two, the first of which is `j`.
    #[inline(always)]
    fn rows<K: Machine<T>>(
        &self,
        k: K,
        rows: &mut [T],
        w: &[T],
        j: usize,
        (direction, parity): (u32, usize),
        sums: &mut [T],
    ) {
        match self.kind {
            Kind::Hard if self.bound > T::of(0.0) => self.hard::<K, true>(k, rows, w, j, (direction, parity)),
            Kind::Hard => self.hard::<K, false>(k, rows, w, j, (direction, parity)),
            Kind::Soft { .. } => self.colour::<K, SOFT>(k, rows, w, j, (direction, parity), sums),
            Kind::Limit => self.colour::<K, LIMIT>(k, rows, w, j, (direction, parity), sums),
        }
    }

    #[inline(always)]
    fn colour<K: Machine<T>, const KIND: u8>(
        &self,
        k: K,
        rows: &mut [T],
        w: &[T],
        j: usize,
        (direction, parity): (u32, usize),
        sums: &mut [T],
    ) {
        let [evens, even, odd] = self.columns;
        match direction {
            0 => self.right::<K, KIND>(k, rows, w, j, parity, [even, odd][parity], sums),
            1 => self.between::<K, KIND, DOWN>(k, rows, w, (j, false), [evens, even], sums),
            2 => self.between::<K, KIND, DIAGONAL>(k, rows, w, (j, false), [even, odd], sums),
            _ => self.between::<K, KIND, DIAGONAL>(k, rows, w, (j, true), [even, odd], sums),
        }
    }

    #[inline(always)]
    fn right<K: Machine<T>, const KIND: u8>(
        &self,
        k: K,
        row: &mut [T],
        w: &[T],
        j: usize,
        parity: usize,
        count: usize,
        sums: &mut [T],
    ) {
        let half = self.half;
        let w = &w[j * 2 * half..][..2 * half];
        let [x, y, z] = planes(row, half).map(|p| p.split_at_mut(half));
        let (we, wo) = w.split_at(half);
        let stored = j * 2 * half + parity * half;
        let sums = sums.get_mut(parity * half..).unwrap_or(&mut []);
        let e = [x.0, y.0, z.0];
        let o = [x.1, y.1, z.1];
        if parity == 0 {
            self.relax::<K, KIND, RIGHT>(k, End { at: e, w: we }, End { at: o, w: wo }, stored, count, sums);
        } else {
            self.relax::<K, KIND, RIGHT>(
                k,
                End { at: o, w: wo },
                End { at: e.map(|p| &mut p[1..]), w: &we[1..] },
                stored,
                count,
                sums,
            );
        }
    }

    /// Springs between two rows: the halves of the upper and of the lower row that they join, for both halves in turn, and
    /// from which number on. Those up right are stored at their lower left end.
    #[inline(always)]
    fn between<K: Machine<T>, const KIND: u8, const WAY: u8>(
        &self,
        k: K,
        rows: &mut [T],
        w: &[T],
        (j, up): (usize, bool),
        counts: [usize; 2],
        sums: &mut [T],
    ) {
        for side in 0..2 {
            let other = if WAY == DOWN { side } else { 1 - side };
            let skip = if WAY == DOWN { 0 } else { side };
            let (halves, from) = if up { ([other, side], [skip, 0]) } else { ([side, other], [0, skip]) };
            let (upper, lower) = ends(rows, w, j, self.half, halves, from);
            let (a, b) = if up { (lower, upper) } else { (upper, lower) };
            let at = (2 * usize::from(up) + side) * self.half;
            let sums = sums.get_mut(at..).unwrap_or(&mut []);
            self.relax::<K, KIND, WAY>(k, a, b, j * 2 * self.half + at, counts[side], sums);
        }
    }

    #[inline(always)]
    fn relax<K: Machine<T>, const KIND: u8, const WAY: u8>(
        &self,
        k: K,
        a: End<T>,
        b: End<T>,
        stored: usize,
        count: usize,
        sums: &mut [T],
    ) {
        match KIND {
            ALIKE => self.equals::<K, false, WAY>(k, a, b, stored, count),
            ALIKE_BOUND => self.equals::<K, true, WAY>(k, a, b, stored, count),
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
        let (span, short) = (k.splat(self.span), k.splat(T::of(aside::SHORT)));
        let [ax, ay, az] = a.at;
        let [bx, by, bz] = b.at;
        for at in (0..count).step_by(K::WIDE) {
            let p = [k.load(ax, at), k.load(ay, at), k.load(az, at)];
            let q = [k.load(bx, at), k.load(by, at), k.load(bz, at)];
            let (wa, wb) = (k.load(a.w, at), k.load(b.w, at));
            let mut rest = value(k, self.rest, stored + at);
            if at + K::WIDE > count {
                // Past the last column there is no spring.
                rest = k.first(rest, count - at);
            }
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
        a: End<T>,
        b: End<T>,
        stored: usize,
        count: usize,
    ) {
        let (zero, half, closest) = (k.splat(T::of(0.0)), k.splat(T::of(0.5)), k.splat(T::of(1e-9)));
        let short = k.splat(T::of(aside::SHORT));
        let [ax, ay, az] = a.at;
        let [bx, by, bz] = b.at;
        for at in (0..count).step_by(K::WIDE) {
            let p = [k.load(ax, at), k.load(ay, at), k.load(az, at)];
            let q = [k.load(bx, at), k.load(by, at), k.load(bz, at)];
            let mut d = [k.sub(q[0], p[0]), k.sub(q[1], p[1]), k.sub(q[2], p[2])];
            let mut far = k.most(k.sqrt(k.squares(d)), closest);
            let mut rest = value(k, self.rest, stored + at);
            if at + K::WIDE > count {
                // Past the last column there is no spring.
                rest = k.first(rest, count - at);
            }
            if WAY == RIGHT && k.any(k.above(k.mul(rest, short), far)) {
                (d, far) = self.turned(k, d, rest, far, stored + at);
            }
            let share = k.div(k.mul(half, rest), far);
            let mut g = k.sub(half, share);
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
        let error = k.choose(k.above(error, most), most, error);
        k.choose(k.above(least, error), least, error)
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

/// The halves `side` of two rows, each from `from` on.
#[inline(always)]
fn ends<'a, T>(
    rows: &'a mut [T],
    w: &'a [T],
    j: usize,
    half: usize,
    side: [usize; 2],
    from: [usize; 2],
) -> (End<'a, T>, End<'a, T>) {
    let (upper, lower) = rows.split_at_mut(6 * half);
    let cut =
        |row: &'a mut [T], n: usize| planes(row, half).map(|p| &mut p[side[n] * half + from[n]..(side[n] + 1) * half]);
    let weights = |n: usize| &w[((j + n) * 2 + side[n]) * half + from[n]..((j + n) * 2 + side[n] + 1) * half];
    (End { at: cut(upper, 0), w: weights(0) }, End { at: cut(lower, 1), w: weights(1) })
}
