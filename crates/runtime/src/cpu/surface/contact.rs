//! Twin of shaders/surface_contact.wgsl: particles leave the planes that they meet in the steps of a frame.

use crate::cpu::rows::Threads;
use crate::cpu::sheet::{Sheet, planes, planes_ref};
use crate::number::aligned::Aligned;
use crate::number::lanes::{LANES, Machine, Work, widest};
use crate::number::real::{Real, V3};

/// Rows that are done in one go.
const TOGETHER: usize = 32;

/// The clearance of a particle that meets nothing.
pub const NOTHING: f64 = -1e30;

/// A plane that moves in a frame.
#[derive(Clone, Copy, Debug)]
pub struct Plane<T> {
    /// A point of it, and its normal, at the end of the frame.
    pub at: V3<T>,
    pub normal: V3<T>,
    /// How fast they get there \[m/s, 1/s\].
    pub drift: V3<T>,
    pub turn: V3<T>,
    /// Distance \[m\] that the particle keeps.
    pub clearance: T,
}

/// The planes of a sheet.
pub struct Planes<T: Real> {
    /// As those of [`Plane`], in the layout of [`Sheet::now`].
    at: Aligned<T>,
    normal: Aligned<T>,
    drift: Aligned<T>,
    turn: Aligned<T>,
    /// In the layout of [`Sheet::w`].
    clearance: Vec<T>,
    /// For each block of [`Sheet::w`] whether any particle in it has a plane.
    any: Vec<bool>,
}

impl<T: Real> Planes<T> {
    /// Without a plane.
    pub fn new(sheet: &Sheet<T>) -> Self {
        let list = || Aligned::zeros(sheet.now.len());
        let clearance = vec![T::of(NOTHING); sheet.w.len()];
        let any = vec![false; sheet.w.len() / LANES];
        Planes { at: list(), normal: list(), drift: list(), turn: list(), clearance, any }
    }

    /// Takes all planes away.
    pub fn clear(&mut self) {
        self.clearance.fill(T::of(NOTHING));
        self.any.fill(false);
    }

    /// Gives a plane to the particle at these places in [`Sheet::w`] and in [`Sheet::now`].
    pub fn put(&mut self, (single, triple): (usize, usize), half: usize, plane: &Plane<T>) {
        for c in 0..3 {
            let place = triple + 2 * c * half;
            self.at[place] = plane.at[c];
            self.normal[place] = plane.normal[c];
            self.drift[place] = plane.drift[c];
            self.turn[place] = plane.turn[c];
        }
        self.clearance[single] = plane.clearance;
        self.any[single / LANES] = true;
    }

    /// The plane of the particle at these places, if it has one.
    pub fn get(&self, (single, triple): (usize, usize), half: usize) -> Option<Plane<T>> {
        let clearance = self.clearance[single];
        let of = |list: &Aligned<T>| [0, 1, 2].map(|c| list[triple + 2 * c * half]);
        let (at, normal, drift, turn) = (of(&self.at), of(&self.normal), of(&self.drift), of(&self.turn));
        (clearance > T::of(NOTHING)).then_some(Plane { at, normal, drift, turn, clearance })
    }
}

/// Particles nearer to their planes than their clearance leave along the normal, and friction takes back their way along the plane since
/// the last step, by at most `friction` times that. `left` \[s\] of the frame are to go after the step of `dt` \[s\].
pub fn run<T: Real>(threads: &Threads, sheet: &mut Sheet<T>, planes: &Planes<T>, friction: T, (dt, left): (T, T)) {
    let (half, row) = (sheet.half, sheet.row());
    let (w, before) = (&sheet.w[..], &sheet.before[..]);
    threads.chunks(&mut sheet.now, TOGETHER * row, |chunk, rows| {
        widest(Rows { rows, first: chunk * TOGETHER, half, w, before, planes, friction, dt, left });
    });
}

struct Rows<'a, 'b, T: Real> {
    rows: &'b mut [T],
    first: usize,
    half: usize,
    w: &'a [T],
    before: &'a [T],
    planes: &'a Planes<T>,
    friction: T,
    dt: T,
    left: T,
}

impl<T: Real> Work<T> for Rows<'_, '_, T> {
    #[inline(always)]
    fn run<K: Machine<T>>(self, k: K) {
        let (half, wide) = (self.half, 2 * self.half);
        let (zero, one, left, dt) = (k.splat(T::of(0.0)), k.splat(T::of(1.0)), k.splat(self.left), k.splat(self.dt));
        let friction = k.splat(self.friction);
        let rubs = self.friction > T::of(0.0);
        for (n, row) in self.rows.chunks_exact_mut(3 * wide).enumerate() {
            let j = self.first + n;
            let any = &self.planes.any[j * wide / LANES..(j + 1) * wide / LANES];
            if !any.contains(&true) {
                continue;
            }
            let part = j * 3 * wide..(j + 1) * 3 * wide;
            let at_end = planes_ref(&self.planes.at[part.clone()], half);
            let normals = planes_ref(&self.planes.normal[part.clone()], half);
            let drifts = planes_ref(&self.planes.drift[part.clone()], half);
            let turns = planes_ref(&self.planes.turn[part.clone()], half);
            let was = planes_ref(&self.before[part], half);
            let (w, clearance) = (&self.w[j * wide..(j + 1) * wide], &self.planes.clearance[j * wide..(j + 1) * wide]);
            let [x, y, z] = planes(row, half);
            for at in (0..wide).step_by(K::WIDE) {
                if !any[at / LANES] {
                    continue;
                }
                let p = [k.load(x, at), k.load(y, at), k.load(z, at)];
                let drift = [k.load(drifts[0], at), k.load(drifts[1], at), k.load(drifts[2], at)];
                let turn = [k.load(turns[0], at), k.load(turns[1], at), k.load(turns[2], at)];
                let q = [k.load(at_end[0], at), k.load(at_end[1], at), k.load(at_end[2], at)];
                let normal = [k.load(normals[0], at), k.load(normals[1], at), k.load(normals[2], at)];
                let q = k.minus(q, k.times(drift, left));
                let normal = k.minus(normal, k.times(turn, left));
                let depth = k.sub(k.load(clearance, at), k.dot(k.minus(p, q), normal));
                let free = k.above(k.load(w, at), zero);
                let meets = k.both(free, k.above(depth, zero));
                if !k.any(meets) {
                    continue;
                }
                let mut out = k.plus(p, k.times(normal, depth));
                if rubs {
                    let from = [k.load(was[0], at), k.load(was[1], at), k.load(was[2], at)];
                    let moved = k.minus(k.minus(out, from), k.times(drift, dt));
                    let along = k.minus(moved, k.times(normal, k.dot(moved, normal)));
                    let (far, most) = (k.sqrt(k.squares(along)), k.mul(friction, depth));
                    let share = k.choose(k.at_least(most, far), one, k.div(most, far));
                    out = k.minus(out, k.times(along, share));
                }
                k.store(x, at, k.choose(meets, out[0], p[0]));
                k.store(y, at, k.choose(meets, out[1], p[1]));
                k.store(z, at, k.choose(meets, out[2], p[2]));
            }
        }
    }
}
