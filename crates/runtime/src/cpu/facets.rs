//! Sums over the triangles around every particle, for as many particles at once as the machine has lanes.
//!
//! A triangle is computed once and added to its three corners, where shaders compute it for each: the sums differ by
//! rounding. Rows beside gaps and holes, where triangles differ from particle to particle, are made by the particle.

mod planes;
mod texels;

pub use planes::Planes;
pub use texels::Texels;

use super::rows::Threads;
use crate::number::lanes::{LANES, Machine, Work, widest};
use crate::number::real::Real;

/// A quantity that is summed over triangles.
pub trait Facets<T: Real>: Copy + Send + Sync {
    /// The value of a triangle, from its corners now and one step before, counter-clockwise seen from the front.
    fn facet<K: Machine<T>>(&mut self, k: K, now: [[K::V; 3]; 3], before: [[K::V; 3]; 3]) -> [K::V; 3];
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
    /// Copies a row of particles; whether all of its texels are particles and all of its quads are there.
    fn fill(&self, j: usize, row: &mut Row<T>) -> bool;
    /// Copies a row of results.
    fn put(&self, from: &[Vec<T>; 4], to: &mut [Self::Item]);
    /// Makes a row of results particle by particle, where quads are missing.
    fn mend(&self, _j: usize, _to: &mut [Self::Item]) {}
}

/// Rows that are done in one go: each chunk has its own lists, and computes the rows of triangles at both of its ends again.
const TOGETHER: usize = 32;

/// Writes the result of every particle.
pub fn run<T: Real, P: Place<T>>(threads: &Threads, facets: impl Facets<T>, place: P, results: &mut [P::Item]) {
    threads.chunks(results, TOGETHER * place.row(), |chunk, results| {
        widest(Chunk { facets, place, first: chunk * TOGETHER, results });
    });
}

/// Rows of particles from the row `first` on.
struct Chunk<'b, F, P, I> {
    facets: F,
    place: P,
    first: usize,
    results: &'b mut [I],
}

/// A row of particles by coordinates, with room for a vector past its end. `before` is 0 if no facet reads it.
pub struct Row<T> {
    now: [Vec<T>; 3],
    before: [Vec<T>; 3],
    w: Vec<T>,
}

/// Values of the quads of a row: of the triangle at their lower left, of that at their upper right, and of both. The quad `i`
/// is at `i + 1`, between zeros.
struct Quads<T> {
    left: [Vec<T>; 3],
    right: [Vec<T>; 3],
    both: [Vec<T>; 3],
}

impl<T: Real> Row<T> {
    fn new(width: usize) -> Self {
        let list = || vec![T::of(0.0); width + 1 + LANES];
        Row { now: [list(), list(), list()], before: [list(), list(), list()], w: list() }
    }
}

impl<T: Real> Quads<T> {
    fn new(width: usize) -> Self {
        let list = || [0; 3].map(|_| vec![T::of(0.0); width + 1 + LANES]);
        Quads { left: list(), right: list(), both: list() }
    }

    fn clear(&mut self) {
        let all = self.left.iter_mut().chain(&mut self.right).chain(&mut self.both);
        all.for_each(|list| list.fill(T::of(0.0)));
    }

    /// The quads between two rows.
    #[inline(always)]
    fn fill<K: Machine<T>>(&mut self, k: K, facets: &mut impl Facets<T>, upper: &Row<T>, lower: &Row<T>, width: usize) {
        for at in (0..width - 1).step_by(K::WIDE) {
            // From the upper left by way of the upper right.
            let [p, q] = [k.loads(&upper.now, at), k.loads(&upper.now, at + 1)];
            let [r, s] = [k.loads(&lower.now, at + 1), k.loads(&lower.now, at)];
            let [e, f] = [k.loads(&upper.before, at), k.loads(&upper.before, at + 1)];
            let [g, h] = [k.loads(&lower.before, at + 1), k.loads(&lower.before, at)];
            // A loop, so that a facet is compiled once.
            let (now, before) = ([[p, q, r], [p, r, s]], [[e, f, g], [e, g, h]]);
            let mut sides = [p; 2];
            for side in 0..2 {
                sides[side] = facets.facet(k, now[side], before[side]);
            }
            let count = width - 1 - at;
            let [right, left] = sides;
            for (c, (right, left)) in right.into_iter().zip(left).enumerate() {
                // Past the last quad there are zeros.
                let (right, left) = (k.first(right, count), k.first(left, count));
                k.store(&mut self.left[c], at + 1, left);
                k.store(&mut self.right[c], at + 1, right);
                k.store(&mut self.both[c], at + 1, k.add(left, right));
            }
        }
    }
}

impl<T: Real, F: Facets<T>, P: Place<T>> Work<T> for Chunk<'_, F, P, P::Item> {
    #[inline(always)]
    fn run<K: Machine<T>>(self, k: K) {
        let Chunk { mut facets, place, first, results } = self;
        let (width, height) = place.size();
        let [mut above, mut here, mut below] = [0; 3].map(|_| Row::new(width));
        let [mut over, mut under] = [0; 2].map(|_| Quads::new(width));
        let mut sums = [0; 4].map(|_| vec![T::of(0.0); width + LANES]);
        // Whether the row above, this one and the one below are whole.
        let mut whole = [true; 3];
        whole[1] = place.fill(first, &mut here);
        if first > 0 {
            whole[0] = place.fill(first - 1, &mut above);
            over.fill(k, &mut facets, &above, &here, width);
        }
        for (n, results) in results.chunks_exact_mut(place.row()).enumerate() {
            let j = first + n;
            if j + 1 < height {
                whole[2] = place.fill(j + 1, &mut below);
                under.fill(k, &mut facets, &here, &below, width);
            } else {
                (whole[2], ()) = (true, under.clear());
            }
            if whole == [true; 3] {
                row(k, &facets, (&over, &under), (&here.w, width), &mut sums);
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
    (w, width): (&[T], usize),
    results: &mut [Vec<T>; 4],
) {
    for at in (0..width).step_by(K::WIDE) {
        let above = k.plus(k.loads(&over.left, at + 1), k.loads(&over.both, at));
        let below = k.plus(k.loads(&under.both, at + 1), k.loads(&under.right, at));
        let of = facets.particle(k, k.plus(above, below), k.load(w, at));
        for c in 0..4 {
            k.store(&mut results[c], at, of[c]);
        }
    }
}
