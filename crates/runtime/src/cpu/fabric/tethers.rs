//! Twin of shaders/tethers.wgsl: no particle is farther from its anchors than along the surface.

use super::anchors::Anchors;
use crate::cpu::rows::Threads;
use crate::cpu::sheet::{Sheet, columns, planes};
use crate::number::lanes::{LANES, Machine, Work, widest};
use crate::number::real::{Real, V3};

/// The anchors of a sheet, in slots.
pub struct Tethers<T> {
    pub slots: Vec<Slot<T>>,
}

/// At most one anchor a particle.
pub struct Slot<T> {
    /// Largest distance \[m\]; very large where there is no anchor. In the layout of [`Sheet::w`].
    pub most: Vec<T>,
    /// Index among the anchors' positions.
    pub anchor: Vec<u32>,
    /// For every block of lanes the one anchor of all, or `MIXED`.
    pub block: Vec<u32>,
    /// The same for the whole sheet.
    pub one: u32,
}

/// The lanes of a block have several anchors.
pub const MIXED: u32 = u32::MAX;

impl<T: Real> Slot<T> {
    /// From the index of the anchor and the distance of each texel.
    pub fn new(sheet: &Sheet<T>, of: impl Fn(usize) -> Option<(u32, T)>) -> Self {
        let none = T::of(f64::from(f32::MAX));
        let most = sheet.list(none, |k| of(k).map_or(none, |(_, distance)| distance));
        let mut anchor = vec![MIXED; most.len()];
        (0..sheet.width * sheet.height)
            .filter_map(|k| Some((k, of(k)?.0)))
            .for_each(|(k, a)| anchor[sheet.single(k)] = a);
        let one = |lanes: &[u32]| {
            let mut there = lanes.iter().filter(|a| **a != MIXED);
            let first = there.next().copied().unwrap_or(0);
            if there.all(|a| *a == first) { first } else { MIXED }
        };
        let block = anchor.chunks(LANES).map(one).collect();
        let one = one(&anchor);
        Slot { most, anchor, block, one }
    }
}

/// Rows that are done in one go.
const TOGETHER: usize = 32;

/// Draws every particle beyond its distance back, anchor by anchor.
///
/// After T. Kim, N. Chentanez, M. Mueller, "Long Range Attachments", SCA 2012: hard and one after the other.
pub fn run<T: Real>(threads: &Threads, sheet: &mut Sheet<T>, tethers: &Tethers<T>, anchors: &Anchors<T>) {
    let (size, row) = ((sheet.width, sheet.half), sheet.row());
    let w = &sheet.w[..];
    threads.chunks(&mut sheet.now, TOGETHER * row, |chunk, rows| {
        let first = chunk * TOGETHER * 2 * size.1;
        widest(Rows { rows, size, w, first, tethers, anchors });
    });
}

/// Rows of a sheet, the first of them at `first` in `w`.
pub struct Rows<'a, 'b, T: Real> {
    pub rows: &'b mut [T],
    /// Columns, and numbers in half a row.
    pub size: (usize, usize),
    pub w: &'a [T],
    pub first: usize,
    pub tethers: &'a Tethers<T>,
    pub anchors: &'a Anchors<'a, T>,
}

impl<T: Real> Work<T> for Rows<'_, '_, T> {
    #[inline(always)]
    fn run<K: Machine<T>>(self, k: K) {
        draw(k, self.rows, self.tethers, self.size, (self.w, self.first), self.anchors);
    }
}

/// Rows of a sheet, given its columns and the numbers in half a row; their weights are those of `w` from `first` on.
#[inline(always)]
pub fn draw<T: Real, K: Machine<T>>(
    k: K,
    rows: &mut [T],
    tethers: &Tethers<T>,
    (width, half): (usize, usize),
    (w, first): (&[T], usize),
    anchors: &Anchors<T>,
) {
    // Slot by slot: the other way round each particle would wait for the roots of all its slots.
    for (slot, to) in tethers.slots.iter().zip(anchors.planes) {
        let one = anchors.at.get(slot.one as usize).map(|anchor| k.splats(*anchor));
        for (n, row) in rows.chunks_exact_mut(6 * half).enumerate() {
            let first = first + n * 2 * half;
            let p = planes(row, half);
            // All as long, so that this is checked once.
            let limits = (&w[first..first + 2 * half], &slot.most[first..first + 2 * half]);
            if let Some(anchor) = one {
                to_one(k, p, limits, (width, half), anchor);
            } else if slot.one == MIXED {
                let to = &to[3 * first..3 * first + 6 * half];
                to_several(k, p, limits, (width, half), &slot.block[first / LANES..], (anchors.at, to));
            }
        }
    }
}

/// A row whose particles have one anchor; `w` are their inverse masses and `most` their distances.
#[inline(always)]
fn to_one<T: Real, K: Machine<T>>(
    k: K,
    [x, y, z]: [&mut [T]; 3],
    (w, most): (&[T], &[T]),
    (width, half): (usize, usize),
    anchor: [K::V; 3],
) {
    for at in columns(width, half, K::WIDE) {
        hold_within(k, [x, y, z], at, anchor, (k.load(w, at), k.load(most, at)));
    }
}

/// A row whose particles have several. Those of a block are `to`, as in a row of [`Anchors::planes`], unless it has one.
#[inline(always)]
fn to_several<T: Real, K: Machine<T>>(
    k: K,
    [x, y, z]: [&mut [T]; 3],
    (w, most): (&[T], &[T]),
    (width, half): (usize, usize),
    blocks: &[u32],
    (anchors, to): (&[V3<T>], &[T]),
) {
    for at in columns(width, half, K::WIDE) {
        let one = blocks[at / LANES];
        let anchor = if one == MIXED {
            [k.load(to, at), k.load(to, 2 * half + at), k.load(to, 4 * half + at)]
        } else {
            k.splats(anchors.get(one as usize).copied().unwrap_or([T::of(0.0); 3]))
        };
        hold_within(k, [x, y, z], at, anchor, (k.load(w, at), k.load(most, at)));
    }
}

/// Vectors of which no particle is beyond this share of its distance are left as they are, without roots and divisions. The margin
/// is wider than what rounding of squares may amount to.
const SURE: f64 = 1.0 - 1e-5;

/// Draws the free particles of a vector, at `at`, to within `most` \[m\] of `to`; `w` are their inverse masses.
#[inline(always)]
pub fn hold_within<T: Real, K: Machine<T>>(
    k: K,
    [x, y, z]: [&mut [T]; 3],
    at: usize,
    to: [K::V; 3],
    (w, most): (K::V, K::V),
) {
    let (zero, least) = (k.splat(T::of(0.0)), k.splat(T::of(1e-30)));
    let none = k.splat(T::of(f64::from(f32::MAX)));
    let p = [k.load(x, at), k.load(y, at), k.load(z, at)];
    let d = [k.sub(p[0], to[0]), k.sub(p[1], to[1]), k.sub(p[2], to[2])];
    let (squares, sure) = (k.squares(d), k.mul(most, k.splat(T::of(SURE))));
    if !k.any(k.above(squares, k.mul(sure, sure))) {
        return;
    }
    let far = k.sqrt(squares);
    let most = k.choose(k.above(w, zero), most, none);
    let keep = k.div(most, k.most(far, least));
    let beyond = k.above(far, most);
    k.store(x, at, k.choose(beyond, k.add(to[0], k.mul(d[0], keep)), p[0]));
    k.store(y, at, k.choose(beyond, k.add(to[1], k.mul(d[1], keep)), p[1]));
    k.store(z, at, k.choose(beyond, k.add(to[2], k.mul(d[2], keep)), p[2]));
}
