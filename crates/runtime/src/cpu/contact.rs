//! Twin of shaders/contact.wgsl: swept collision with moving colliders, and friction.

use super::colliders::rub;
use super::lanes::{LANES, Machine, Work, widest};
use super::real::{Real, V3, add, cross, dot, scale, sub};
use super::rows::Threads;
use super::sheet::{Sheet, planes, planes_ref};
use super::solid::Solid;

/// Rows that are done in one go.
const TOGETHER: usize = 8;

/// Particles inside a collider, or on its other side, go to its surface. Colliders out of reach of the sheet cost one
/// comparison, those out of reach of a block of particles another.
pub fn run<T: Real>(threads: &Threads, sheet: &mut Sheet<T>, solids: &[Solid<T>], dt: T) {
    let near = in_reach(bounds(sheet), solids, dt);
    if near.is_empty() {
        return;
    }
    let (half, row) = (sheet.half, sheet.row());
    let (w, before) = (&sheet.w[..], &sheet.before[..]);
    threads.chunks(&mut sheet.now, TOGETHER * row, |chunk, rows| {
        widest(Rows { rows, row, half, w, before, first: chunk * TOGETHER, near: &near, dt });
    });
}

/// The colliders that particles in a box can touch, in their order: also those that another one can push them to.
fn in_reach<T: Real>(
    (mut lowest, mut highest): (V3<T>, V3<T>),
    solids: &[Solid<T>],
    dt: T,
) -> Vec<(&Solid<T>, Reach<T>)> {
    let mut all: Vec<_> = solids.iter().map(|s| (s, Reach::new(s, dt), false)).collect();
    loop {
        let mut more = false;
        let (low, high) = (lowest, highest);
        for (_, reach, near) in all.iter_mut().filter(|x| !x.2 && x.1.box_near(low, high)) {
            (*near, more) = (true, true);
            let far = reach.pushes(low, high);
            for c in 0..3 {
                lowest[c] = lowest[c].min(far.0[c]);
                highest[c] = highest[c].max(far.1[c]);
            }
        }
        if !more {
            return all.into_iter().filter(|x| x.2).map(|(solid, reach, _)| (solid, reach)).collect();
        }
    }
}

/// Rows of a sheet from the row `first` on, and what they can touch.
struct Rows<'a, 'b, T> {
    rows: &'b mut [T],
    row: usize,
    half: usize,
    w: &'a [T],
    before: &'a [T],
    first: usize,
    near: &'a [(&'a Solid<T>, Reach<T>)],
    dt: T,
}

impl<T: Real> Work<T> for Rows<'_, '_, T> {
    #[inline(always)]
    fn run<K: Machine<T>>(self, k: K) {
        let Rows { row, half, .. } = self;
        for (n, now) in self.rows.chunks_exact_mut(row).enumerate() {
            let j = self.first + n;
            let was = planes_ref(&self.before[j * row..(j + 1) * row], half);
            let w = &self.w[j * 2 * half..(j + 1) * 2 * half];
            let mut now = planes(now, half);
            for at in (0..2 * half).step_by(K::WIDE) {
                for (solid, reach) in self.near {
                    if reach.any_near(k, [&*now[0], &*now[1], &*now[2]], was, at) {
                        (at..at + K::WIDE).filter(|n| w[*n] > T::of(0.0)).for_each(|n| {
                            touch(solid, &mut now, was, n, self.dt);
                        });
                    }
                }
            }
        }
    }
}

#[inline(never)]
fn touch<T: Real>(solid: &Solid<T>, now: &mut [&mut [T]; 3], was: [&[T]; 3], n: usize, dt: T) {
    let (p, b) = ([now[0][n], now[1][n], now[2][n]], [was[0][n], was[1][n], was[2][n]]);
    if let Some(out) = meet(solid, p, b, dt) {
        (0..3).for_each(|c| now[c][n] = out[c]);
    }
}

/// Where a particle that went from `was` to `at` in `dt` is put; none if it meets nothing.
#[inline]
pub fn meet<T: Real>(solid: &Solid<T>, at: V3<T>, was: V3<T>, dt: T) -> Option<V3<T>> {
    // Where it would have been before, had the collider always been where it is now.
    let carried = add(solid.velocity, cross(solid.spin, sub(was, solid.center)));
    let from = add(was, scale(carried, dt));
    let (out, normal) = swept(solid, from, at)?;
    let depth = sub(out, at);
    let out =
        if solid.friction > T::of(0.0) { rub(solid, out, normal, was, dot(depth, depth).sqrt(), dt) } else { out };
    // Sliding along a flat or hollow side can end inside again.
    Some(solid.exit(out).map_or(out, |(at, _)| at))
}

/// The way out of a solid at rest for a particle that went from `from` to `at`.
///
/// After a step far shorter than the solid is thick it is the closest one, which is smooth. After a longer one that could
/// be out of the side or the back: it is by the plane that touches the solid where the path entered, or where it began
/// inside, as resting particles do by rounding.
fn swept<T: Real>(solid: &Solid<T>, from: V3<T>, at: V3<T>) -> Option<(V3<T>, V3<T>)> {
    let path = sub(at, from);
    let short = solid.thickness() * T::of(0.25);
    if dot(path, path) < short * short {
        return solid.exit(at);
    }
    let met = solid.exit(from).or_else(|| solid.entry(from, path));
    met.and_then(|(surface, normal)| out_by(at, surface, normal)).or_else(|| solid.exit(at))
}

fn out_by<T: Real>(at: V3<T>, surface: V3<T>, normal: V3<T>) -> Option<(V3<T>, V3<T>)> {
    let deep = dot(sub(surface, at), normal);
    (deep > T::of(0.0)).then(|| (add(at, scale(normal, deep)), normal))
}

/// A ball or a half-space around all that a solid can touch within a step.
struct Reach<T> {
    center: V3<T>,
    /// Squared radius; none for a half-space.
    radius: Option<T>,
    normal: V3<T>,
}

impl<T: Real> Reach<T> {
    fn new(solid: &Solid<T>, dt: T) -> Self {
        let around = solid.around();
        let v = solid.velocity;
        let moves = dot(v, v).sqrt() * dt;
        let radius = around.map(|r| {
            let s = solid.spin;
            let turns = dot(s, s).sqrt() * dt * r;
            r + moves + turns
        });
        let normal = solid.up();
        Reach { center: solid.center, radius, normal }
    }

    fn box_near(&self, lowest: V3<T>, highest: V3<T>) -> bool {
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
    fn pushes(&self, lowest: V3<T>, highest: V3<T>) -> (V3<T>, V3<T>) {
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

    /// Whether any particle from `at` on comes near on its way: the ball around the way meets that of the solid.
    #[inline(always)]
    fn any_near<K: Machine<T>>(&self, k: K, now: [&[T]; 3], was: [&[T]; 3], at: usize) -> bool {
        let load = |list: [&[T]; 3]| [k.load(list[0], at), k.load(list[1], at), k.load(list[2], at)];
        let between = |a: [K::V; 3], b: [K::V; 3]| [k.sub(a[0], b[0]), k.sub(a[1], b[1]), k.sub(a[2], b[2])];
        let p = load(now);
        let [x, y, z] = self.center;
        let d = between(p, [k.splat(x), k.splat(y), k.splat(z)]);
        match self.radius {
            Some(r) => {
                let way = k.sqrt(k.squares(between(p, load(was))));
                let far = k.sqrt(k.squares(d));
                let reach = k.add(k.splat(r), way);
                // Written so that what is no number is not near: nothing can be done for it.
                k.any(k.above(reach, far))
            }
            None => {
                let n = self.normal.map(|x| k.splat(x));
                let above = k.add(k.add(k.mul(d[0], n[0]), k.mul(d[1], n[1])), k.mul(d[2], n[2]));
                k.any(k.above(k.splat(T::of(0.0)), above))
            }
        }
    }
}

/// The box around all free particles now and before.
fn bounds<T: Real>(sheet: &Sheet<T>) -> (V3<T>, V3<T>) {
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
        for list in [&self.sheet.now, &self.sheet.before] {
            for (j, row) in list.chunks_exact(row).enumerate() {
                let xyz = planes_ref(row, half);
                for at in (0..2 * half).step_by(K::WIDE) {
                    let free = k.above(k.load(&self.sheet.w, j * 2 * half + at), zero);
                    for c in 0..3 {
                        let x = k.load(xyz[c], at);
                        low[c] = k.choose(k.above(low[c], x), k.choose(free, x, low[c]), low[c]);
                        high[c] = k.choose(k.above(x, high[c]), k.choose(free, x, high[c]), high[c]);
                    }
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
