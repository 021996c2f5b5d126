//! Twin of shaders/stretch.wgsl: springs of one direction and parity, with compliance.

mod relax;

pub use relax::TORN;

use std::sync::Arc;

use super::polish::OVER;
use crate::cloth::{Cloth, Compliance, Rest};
use crate::cpu::rows::Threads;
use crate::cpu::sheet::{Sheet, Values, planes};
use crate::number::lanes::{Machine, Work, widest};
use crate::number::real::Real;

/// Rest lengths \[m\]; 0 means no spring, as everywhere past the last column.
#[derive(Clone)]
pub enum Rests<T> {
    /// One for all: as many times as a row has pairs at most, and as many zeros.
    Constant(Arc<Vec<T>>),
    /// In the layout of [`Sheet::w`].
    List(Arc<Vec<T>>),
}

impl<T: Real> Rests<T> {
    /// The same for all springs of a sheet.
    pub fn constant(sheet: &Sheet<T>, rest: T) -> Self {
        Rests::Constant(Arc::new([rest, T::of(0.0)].iter().flat_map(|r| vec![*r; sheet.half]).collect()))
    }

    /// The numbers.
    pub fn list(&self) -> &[T] {
        match self {
            Rests::Constant(row) => row,
            Rests::List(list) => list,
        }
    }

    /// Those of `count` springs, the first of which is stored at `stored`, and zeros up to `long`.
    #[inline(always)]
    fn of(&self, stored: usize, count: usize, long: usize) -> &[T] {
        match self {
            Rests::Constant(row) => &row[row.len() / 2 - count..][..long],
            Rests::List(list) => &list[stored..][..long],
        }
    }
}

/// The springs of one direction.
pub struct Springs<T> {
    /// Rest lengths.
    pub rest: Rests<T>,
    /// Compliance \[m/N\].
    pub soft: Values<T>,
    /// Sums of multipliers of this step; empty until there is more than one relaxation and any compliance.
    pub sums: Vec<T>,
    /// Share of its rest length by which a hard diagonal may move its ends; 0 means no bound. It depends on the step.
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

/// As [`run`] with springs without compliance, each of which moves its ends [`OVER`] times as far.
pub fn far<T: Real>(threads: &Threads, sheet: &mut Sheet<T>, springs: &mut Springs<T>, colour: (u32, u32)) {
    run_colour(threads, sheet, springs, colour, Kind::Over, T::of(1.0));
}

/// As [`run`] with springs that only hold ends together: the rest lengths are the longest allowed.
pub fn limit<T: Real>(threads: &Threads, sheet: &mut Sheet<T>, springs: &mut Springs<T>, direction: u32, parity: u32) {
    run_colour(threads, sheet, springs, (direction, parity), Kind::Limit, T::of(1.0));
}

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
    /// Hard, and moves its ends [`OVER`] times as far.
    Over,
    Soft {
        again: bool,
    },
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
    let over = matches!(kind, Kind::Over);
    let spring = Spring { span, kind, ..Spring::of((width, half), alike, springs).over(over) };
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
    rest: &'a Rests<T>,
    soft: &'a Values<T>,
    half: usize,
    /// As [`Sheet::alike`].
    alike: &'a [T],
    /// Square of the step \[s^2\].
    span: T,
    kind: Kind,
    bound: T,
    /// How many times as far as their lengths ask springs to the right and down move their ends.
    times: T,
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
    /// Hard ones, of a sheet of `width` columns with `half` numbers in half a row.
    pub fn of((width, half): (usize, usize), alike: &'a [T], springs: &'a Springs<T>) -> Self {
        let columns = [width.div_ceil(2), width / 2, (width - 1) / 2];
        let Springs { rest, soft, bound, .. } = springs;
        Spring {
            rest,
            soft,
            half,
            alike,
            span: T::of(1.0),
            kind: Kind::Hard,
            bound: *bound,
            times: T::of(1.0),
            columns,
        }
    }

    /// Those of a round of polish, or as they are.
    pub fn over(self, over: bool) -> Self {
        Spring { times: T::of(if over { OVER } else { 1.0 }), ..self }
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
            Kind::Hard | Kind::Over if self.bound > T::of(0.0) => {
                self.hard::<K, true>(k, rows, w, j, (direction, parity))
            }
            Kind::Hard | Kind::Over => self.hard::<K, false>(k, rows, w, j, (direction, parity)),
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
            0 => self.right::<K, KIND>(k, rows, w, (j, parity), [even, odd][parity], sums),
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
        (j, parity): (usize, usize),
        count: usize,
        sums: &mut [T],
    ) {
        let half = self.half;
        let [x, y, z] = planes(row, half);
        let (x, y, z) = (x.split_at_mut(half), y.split_at_mut(half), z.split_at_mut(half));
        let (we, wo) = if weighs(KIND) { w[j * 2 * half..][..2 * half].split_at(half) } else { (&[][..], &[][..]) };
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
                End { at: after_first(e), w: we.get(1..).unwrap_or(&[]) },
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
        for (side, count) in counts.into_iter().enumerate() {
            let other = if WAY == DOWN { side } else { 1 - side };
            let skip = if WAY == DOWN { 0 } else { side };
            let (halves, from) = if up { ([other, side], [skip, 0]) } else { ([side, other], [0, skip]) };
            let w = if weighs(KIND) { &w[j * 2 * self.half..] } else { &[] };
            let (upper, lower) = ends(rows, w, self.half, halves, from);
            let (a, b) = if up { (lower, upper) } else { (upper, lower) };
            let at = (2 * usize::from(up) + side) * self.half;
            let sums = sums.get_mut(at..).unwrap_or(&mut []);
            self.relax::<K, KIND, WAY>(k, a, b, j * 2 * self.half + at, count, sums);
        }
    }
}

/// Whether springs of a kind ask for the masses of their ends.
const fn weighs(kind: u8) -> bool {
    kind != ALIKE && kind != ALIKE_BOUND
}

#[inline(always)]
fn after_first<T>([x, y, z]: [&mut [T]; 3]) -> [&mut [T]; 3] {
    [&mut x[1..], &mut y[1..], &mut z[1..]]
}

/// The halves `side` of two rows, each from `from` on; `w` are the inverse masses of these rows, or none.
#[inline(always)]
fn ends<'a, T>(
    rows: &'a mut [T],
    w: &'a [T],
    half: usize,
    side: [usize; 2],
    from: [usize; 2],
) -> (End<'a, T>, End<'a, T>) {
    let (upper, lower) = rows.split_at_mut(6 * half);
    let weights = |n: usize| w.get((2 * n + side[n]) * half + from[n]..).unwrap_or(&[]);
    let [upper, lower] = [cut(upper, half, side[0], from[0]), cut(lower, half, side[1], from[1])];
    (End { at: upper, w: weights(0) }, End { at: lower, w: weights(1) })
}

/// The coordinates of half a row, from `from` on.
#[inline(always)]
fn cut<T>(row: &mut [T], half: usize, side: usize, from: usize) -> [&mut [T]; 3] {
    let [x, y, z] = planes(row, half);
    let range = side * half + from..(side + 1) * half;
    [&mut x[range.clone()], &mut y[range.clone()], &mut z[range]]
}

/// The springs of a grid of a cloth, by direction.
pub fn springs<T: Real>(cloth: &Cloth, g: usize, sheet: &Sheet<T>) -> [Springs<T>; 4] {
    let first = cloth.grids()[g].first as usize;
    let holes = (0..sheet.width * sheet.height).any(|k| !cloth.particles()[first + k].exists());
    [0, 1, 2, 3].map(|d| {
        let zero = T::of(0.0);
        let rest = match cloth.rest() {
            Rest::None => Rests::constant(sheet, zero),
            Rest::Constant(r) if !holes => Rests::constant(sheet, T::of(r[g][d].into())),
            _ => Rests::List(Arc::new(sheet.list(zero, |k| T::of(cloth.spring(g, k, d).into())))),
        };
        let soft = match &cloth.compliance {
            Compliance::None => Values::Constant(zero),
            Compliance::Constant(c) => Values::Constant(T::of(f64::from(*c))),
            Compliance::Image(c) => Values::List(Arc::new(sheet.list(zero, |k| T::of(c[first + k][d].into())))),
        };
        Springs { rest, soft, sums: Vec::new(), bound: zero }
    })
}

#[cfg(test)]
mod tests;
