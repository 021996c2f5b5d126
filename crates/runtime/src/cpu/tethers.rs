//! Twin of shaders/tethers.wgsl: no particle is farther from its anchors than along the surface.

use super::lanes::{LANES, Machine, Work, widest};
use super::real::{Real, V3};
use super::rows::Threads;
use super::sheet::{Sheet, planes};

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
        Slot { most, anchor, block }
    }
}

/// Rows that are done in one go.
const TOGETHER: usize = 32;

/// Draws every particle beyond its distance back, anchor by anchor. `anchors` are their positions now.
///
/// After T. Kim, N. Chentanez, M. Mueller, "Long Range Attachments", SCA 2012: hard and one after the other.
pub fn run<T: Real>(threads: &Threads, sheet: &mut Sheet<T>, tethers: &Tethers<T>, anchors: &[V3<T>]) {
    let (half, row) = (sheet.half, sheet.row());
    let w = &sheet.w[..];
    threads.chunks(&mut sheet.now, TOGETHER * row, |chunk, rows| {
        let first = chunk * TOGETHER * 2 * half;
        widest(Rows { rows, row, half, w, first, tethers, anchors });
    });
}

/// Rows of a sheet, the first of them at `first` in `w`.
struct Rows<'a, 'b, T> {
    rows: &'b mut [T],
    row: usize,
    half: usize,
    w: &'a [T],
    first: usize,
    tethers: &'a Tethers<T>,
    anchors: &'a [V3<T>],
}

impl<T: Real> Work<T> for Rows<'_, '_, T> {
    #[inline(always)]
    fn run<K: Machine<T>>(self, k: K) {
        for (n, row) in self.rows.chunks_exact_mut(self.row).enumerate() {
            let mut xyz = planes(row, self.half);
            draw(k, &mut xyz, self.tethers, self.w, self.first + n * 2 * self.half, self.anchors);
        }
    }
}

#[inline(always)]
fn draw<T: Real, K: Machine<T>>(
    k: K,
    xyz: &mut [&mut [T]; 3],
    tethers: &Tethers<T>,
    w: &[T],
    first: usize,
    anchors: &[V3<T>],
) {
    let (zero, least) = (k.splat(T::of(0.0)), k.splat(T::of(1e-30)));
    for at in (0..xyz[0].len()).step_by(K::WIDE) {
        let place = first + at;
        let free = k.above(k.load(w, place), zero);
        let [mut x, mut y, mut z] = [k.load(xyz[0], at), k.load(xyz[1], at), k.load(xyz[2], at)];
        for slot in &tethers.slots {
            let anchor = to(k, slot, place, anchors);
            let d = [k.sub(x, anchor[0]), k.sub(y, anchor[1]), k.sub(z, anchor[2])];
            let far = k.sqrt(k.squares(d));
            let most = k.load(&slot.most, place);
            let keep = k.div(most, k.most(far, least));
            let beyond = k.above(far, most);
            x = k.choose(free, k.choose(beyond, k.add(anchor[0], k.mul(d[0], keep)), x), x);
            y = k.choose(free, k.choose(beyond, k.add(anchor[1], k.mul(d[1], keep)), y), y);
            z = k.choose(free, k.choose(beyond, k.add(anchor[2], k.mul(d[2], keep)), z), z);
        }
        k.store(xyz[0], at, x);
        k.store(xyz[1], at, y);
        k.store(xyz[2], at, z);
    }
}

#[inline(always)]
fn to<T: Real, K: Machine<T>>(k: K, slot: &Slot<T>, place: usize, anchors: &[V3<T>]) -> [K::V; 3] {
    let of = |index: u32| anchors.get(index as usize).copied().unwrap_or([T::of(0.0); 3]);
    let one = slot.block[place / LANES];
    if one != MIXED {
        let [x, y, z] = of(one);
        return [k.splat(x), k.splat(y), k.splat(z)];
    }
    let mut lists = [[T::of(0.0); LANES]; 3];
    for n in 0..K::WIDE {
        let a = of(slot.anchor[place + n]);
        (0..3).for_each(|c| lists[c][n] = a[c]);
    }
    [k.load(&lists[0], 0), k.load(&lists[1], 0), k.load(&lists[2], 0)]
}
