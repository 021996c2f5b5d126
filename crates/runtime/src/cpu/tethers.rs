//! Twin of shaders/tethers.wgsl: no particle is farther from its anchors than along the surface.

use super::lanes::{LANES, Lanes, load, splat, store, widest};
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
        (0..sheet.width * sheet.height).filter_map(|k| Some((k, of(k)?.0))).for_each(|(k, a)| anchor[sheet.single(k)] = a);
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
        widest(
            #[inline(always)]
            || {
                for (n, row) in rows.chunks_exact_mut(row).enumerate() {
                    let first = (chunk * TOGETHER + n) * 2 * half;
                    let mut xyz = planes(row, half);
                    for slot in &tethers.slots {
                        draw(&mut xyz, slot, w, first, anchors);
                    }
                }
            },
        );
    });
}

#[inline(always)]
fn draw<T: Real>(xyz: &mut [&mut [T]; 3], slot: &Slot<T>, w: &[T], first: usize, anchors: &[V3<T>]) {
    let (zero, least) = (T::of(0.0), T::of(1e-30));
    let [x, y, z] = xyz;
    for at in (0..x.len()).step_by(LANES) {
        let place = first + at;
        let (px, py, pz) = (load(x, at), load(y, at), load(z, at));
        let [ax, ay, az] = to(slot, place, anchors);
        let (most, w) = (load(&slot.most, place), load(w, place));
        let (mut dx, mut dy, mut dz) = ([zero; LANES], [zero; LANES], [zero; LANES]);
        for k in 0..LANES {
            dx[k] = px[k] - ax[k];
            dy[k] = py[k] - ay[k];
            dz[k] = pz[k] - az[k];
        }
        let (mut far, mut keep) = ([zero; LANES], [zero; LANES]);
        for k in 0..LANES {
            far[k] = (dx[k] * dx[k] + dy[k] * dy[k] + dz[k] * dz[k]).sqrt();
            keep[k] = most[k] / far[k].max(least);
        }
        let (mut ox, mut oy, mut oz) = ([zero; LANES], [zero; LANES], [zero; LANES]);
        for k in 0..LANES {
            let beyond = far[k] > most[k] && w[k] > zero;
            ox[k] = if beyond { ax[k] + dx[k] * keep[k] } else { px[k] };
            oy[k] = if beyond { ay[k] + dy[k] * keep[k] } else { py[k] };
            oz[k] = if beyond { az[k] + dz[k] * keep[k] } else { pz[k] };
        }
        store(x, at, &ox);
        store(y, at, &oy);
        store(z, at, &oz);
    }
}

#[inline(always)]
fn to<T: Real>(slot: &Slot<T>, place: usize, anchors: &[V3<T>]) -> [Lanes<T>; 3] {
    let of = |index: u32| anchors.get(index as usize).copied().unwrap_or([T::of(0.0); 3]);
    let one = slot.block[place / LANES];
    if one != MIXED {
        return of(one).map(splat);
    }
    let mut out = [[T::of(0.0); LANES]; 3];
    for k in 0..LANES {
        let a = of(slot.anchor[place + k]);
        (0..3).for_each(|c| out[c][k] = a[c]);
    }
    out
}
