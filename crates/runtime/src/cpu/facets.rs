//! Sums over the triangles around every particle, for as many particles at once as the machine has lanes.
//!
//! A triangle is computed once and added to its three corners, where shaders compute it for each: the sums differ by
//! rounding. Rows beside gaps and holes, where triangles differ from particle to particle, are made by the particle.
//! Rows lie as in [`super::sheet`], even columns apart from odd ones, so that those of a sheet are copied as they are.

mod planes;
mod texels;

pub use planes::Planes;
pub use texels::Texels;

use super::rows::Threads;
use super::sheet::{columns, half_row};
use crate::number::lanes::{LANES, Machine, Work, widest};
use crate::number::real::Real;

/// A quantity that is summed over triangles.
pub trait Facets<T: Real>: Copy + Send + Sync {
    /// Whether it depends on a vector of each corner beside its position.
    const CORNERS: bool;
    /// That vector, from the positions of the particle now and one step before, and the velocity of the air there if the place has any.
    fn corner<K: Machine<T>>(&self, _: K, _now: [K::V; 3], before: [K::V; 3], _: Option<[K::V; 3]>) -> [K::V; 3] {
        before
    }
    /// The values of the triangles of a quad at its upper right and at its lower left, from its corners and their vectors, from the upper
    /// left by way of the upper right.
    fn quad<K: Machine<T>>(&self, k: K, now: [[K::V; 3]; 4], corners: [[K::V; 3]; 4]) -> [[K::V; 3]; 2];
    /// The result of a particle with an inverse mass.
    fn particle<K: Machine<T>>(&self, k: K, sum: [K::V; 3], w: K::V) -> [K::V; 4];
}

/// Where particles and results lie.
pub trait Place<T: Real>: Copy + Send + Sync {
    /// Of what results are made.
    type Item: Send;
    /// Particles in a row, and rows.
    fn size(&self) -> (usize, usize);
    /// Items in a row of results.
    fn row(&self) -> usize;
    /// Whether it has velocities of the air.
    fn airs(&self) -> bool;
    /// Copies a row of particles; whether all of its texels are particles and all of its quads are there.
    fn fill(&self, j: usize, row: &mut Row<T>) -> bool;
    /// Copies a row of results.
    fn put(&self, from: &[Vec<T>; 4], to: &mut [Self::Item]);
    /// Makes a row of results particle by particle, where quads are missing.
    fn mend(&self, _j: usize, _to: &mut [Self::Item]) {}
}

/// Rows that a thread does in one go: each chunk has its own lists, and computes the rows of triangles at both of its ends again.
const TOGETHER: usize = 32;

/// Writes the result of every particle.
pub fn run<T: Real, P: Place<T>>(threads: &Threads, facets: impl Facets<T>, place: P, results: &mut [P::Item]) {
    let rows = if threads.alone(results) { place.size().1 } else { TOGETHER };
    threads.chunks(results, rows * place.row(), |chunk, results| {
        widest(Chunk { facets, place, first: chunk * rows, results });
    });
}

/// Rows of particles from the row `first` on.
struct Chunk<'b, F, P, I> {
    facets: F,
    place: P,
    first: usize,
    results: &'b mut [I],
}

/// A row of particles by coordinates, `[even, odd]` each. Of facets without vectors of corners only `now` and `w` are filled.
pub struct Row<T> {
    now: [Vec<T>; 3],
    before: [Vec<T>; 3],
    air: [Vec<T>; 3],
    w: Vec<T>,
}

/// Values of the quads of a row: of the triangle at their lower left, of that at their upper right, and of both. First those
/// that begin at an even column, then, from [`Size::quads`] on, those at an odd one, each after a zero.
struct Quads<T> {
    left: [Vec<T>; 3],
    right: [Vec<T>; 3],
    both: [Vec<T>; 3],
}

/// Columns of a row, numbers in half a row of particles, and in half a row of quads.
#[derive(Clone, Copy)]
struct Size {
    width: usize,
    half: usize,
    quads: usize,
}

impl Size {
    fn new(width: usize) -> Self {
        let half = half_row(width);
        Size { width, half, quads: half + LANES }
    }
}

impl<T: Real> Row<T> {
    fn new(size: Size, [corners, airs]: [bool; 2]) -> Self {
        let list = |there: bool| vec![T::of(0.0); if there { 2 * size.half } else { 0 }];
        let lists = |there: bool| [list(there), list(there), list(there)];
        Row { now: lists(true), before: lists(corners), air: lists(airs), w: list(true) }
    }

    /// Puts the vectors of corners in the place of previous positions.
    #[inline(always)]
    fn corners<K: Machine<T>, F: Facets<T>>(&mut self, k: K, facets: &F, size: Size) {
        if !F::CORNERS {
            return;
        }
        for at in columns(size.width, size.half, K::WIDE) {
            let before = k.loads(&self.before, at);
            let air = if self.air[0].is_empty() { None } else { Some(k.loads(&self.air, at)) };
            let of = facets.corner(k, k.loads(&self.now, at), before, air);
            for (list, of) in self.before.iter_mut().zip(of) {
                k.store(list, at, of);
            }
        }
    }
}

impl<T: Real> Quads<T> {
    fn new(size: Size) -> Self {
        let list = || [0; 3].map(|_| vec![T::of(0.0); 2 * size.quads]);
        Quads { left: list(), right: list(), both: list() }
    }

    fn clear(&mut self) {
        let all = self.left.iter_mut().chain(&mut self.right).chain(&mut self.both);
        all.for_each(|list| list.fill(T::of(0.0)));
    }

    /// The quads between two rows.
    #[inline(always)]
    fn fill<K: Machine<T>, F: Facets<T>>(&mut self, k: K, facets: &F, upper: &Row<T>, lower: &Row<T>, size: Size) {
        for odd in 0..2 {
            let all = (size.width - odd) / 2;
            for at in (0..all).step_by(K::WIDE) {
                let (near, far) = (odd * size.half + at, (1 - odd) * size.half + at + odd);
                let [p, q] = [k.loads(&upper.now, near), k.loads(&upper.now, far)];
                let [r, s] = [k.loads(&lower.now, far), k.loads(&lower.now, near)];
                let mut corners = [p; 4];
                if F::CORNERS {
                    corners = [
                        k.loads(&upper.before, near),
                        k.loads(&upper.before, far),
                        k.loads(&lower.before, far),
                        k.loads(&lower.before, near),
                    ];
                }
                let [right, left] = facets.quad(k, [p, q, r, s], corners);
                let to = odd * size.quads + at + 1;
                for c in 0..3 {
                    // Past the last quad there are zeros.
                    let (right, left) = (k.first(right[c], all - at), k.first(left[c], all - at));
                    k.store(&mut self.left[c], to, left);
                    k.store(&mut self.right[c], to, right);
                    k.store(&mut self.both[c], to, k.add(left, right));
                }
            }
        }
    }
}

impl<T: Real, F: Facets<T>, P: Place<T>> Work<T> for Chunk<'_, F, P, P::Item> {
    #[inline(always)]
    fn run<K: Machine<T>>(self, k: K) {
        let Chunk { facets, place, first, results } = self;
        let (width, height) = place.size();
        let size = Size::new(width);
        let [mut above, mut here, mut below] = [0; 3].map(|_| Row::new(size, [F::CORNERS, F::CORNERS && place.airs()]));
        let [mut over, mut under] = [0; 2].map(|_| Quads::new(size));
        let mut sums = [0; 4].map(|_| vec![T::of(0.0); 2 * size.half]);
        // Whether the row above, this one and the one below are whole.
        let mut whole = [true; 3];
        whole[1] = place.fill(first, &mut here);
        here.corners(k, &facets, size);
        if first > 0 {
            whole[0] = place.fill(first - 1, &mut above);
            above.corners(k, &facets, size);
            over.fill(k, &facets, &above, &here, size);
        }
        for (n, results) in results.chunks_exact_mut(place.row()).enumerate() {
            let j = first + n;
            if j + 1 < height {
                whole[2] = place.fill(j + 1, &mut below);
                below.corners(k, &facets, size);
                under.fill(k, &facets, &here, &below, size);
            } else {
                (whole[2], ()) = (true, under.clear());
            }
            if whole == [true; 3] {
                row(k, &facets, (&over, &under), (&here.w, size), &mut sums);
                place.put(&sums, results);
            } else {
                place.mend(j, results);
            }
            std::mem::swap(&mut over, &mut under);
            std::mem::swap(&mut above, &mut here);
            std::mem::swap(&mut here, &mut below);
            whole = [whole[1], whole[2], true];
        }
    }
}

/// The particles between two rows of quads.
#[inline(always)]
fn row<T: Real, K: Machine<T>>(
    k: K,
    facets: &impl Facets<T>,
    (over, under): (&Quads<T>, &Quads<T>),
    (w, size): (&[T], Size),
    results: &mut [Vec<T>; 4],
) {
    for odd in 0..2 {
        for at in (0..(size.width + 1 - odd) / 2).step_by(K::WIDE) {
            // The quads to the right of these particles, and those to the left.
            let (right, left) = (odd * size.quads + at + 1, (1 - odd) * size.quads + at + odd);
            let above = k.plus(k.loads(&over.left, right), k.loads(&over.both, left));
            let below = k.plus(k.loads(&under.both, right), k.loads(&under.right, left));
            let of = facets.particle(k, k.plus(above, below), k.load(w, odd * size.half + at));
            for c in 0..4 {
                k.store(&mut results[c], odd * size.half + at, of[c]);
            }
        }
    }
}
