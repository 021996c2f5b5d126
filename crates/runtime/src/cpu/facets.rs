//! Sums over the triangles around every particle, for as many particles at once as the machine has lanes.
//!
//! A triangle is computed once and added to its three corners, where shaders compute it for each: the sums differ by
//! rounding. Beside gaps and holes, where triangles differ from particle
//! to particle, the sum is made by the particle ([`View::triangles`]).

use super::neighbours::View;
use super::rows::Threads;
use crate::number::lanes::{LANES, Machine, Work, widest};
use crate::number::real::Real;

/// What is summed.
pub trait Facets<T: Real>: Copy + Send + Sync {
    /// The value of a triangle, from its corners now and one step before, counter-clockwise seen from the front.
    fn facet<K: Machine<T>>(&self, k: K, now: [[K::V; 3]; 3], before: [[K::V; 3]; 3]) -> [K::V; 3];
    /// The result of a particle with an inverse mass.
    fn particle<K: Machine<T>>(&self, k: K, sum: [K::V; 3], w: K::V) -> [K::V; 4];
    /// The same for the particle (i, j) alone, by its own triangles.
    fn alone(&self, i: usize, j: usize) -> [T; 4];
}

/// Rows that are done in one go.
const TOGETHER: usize = 8;

/// Writes the result of every particle. `before` may be empty if no facet reads it.
pub fn run<T: Real>(
    threads: &Threads,
    facets: impl Facets<T>,
    view: View<T>,
    before: &[[T; 4]],
    results: &mut [[T; 4]],
) {
    threads.chunks(results, TOGETHER * view.width, |chunk, results| {
        widest(Chunk { facets, view, before, first: chunk * TOGETHER, results });
    });
}

/// Rows of particles from the row `first` on.
struct Chunk<'a, 'b, T, F> {
    facets: F,
    view: View<'a, T>,
    before: &'a [[T; 4]],
    first: usize,
    results: &'b mut [[T; 4]],
}

/// A row of particles by coordinates, with room for a vector past its end.
struct Row<T> {
    now: [Vec<T>; 3],
    before: [Vec<T>; 3],
    w: Vec<T>,
    /// Whether all of its texels are particles, and all of its quads are there.
    whole: bool,
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
        Row { now: [list(), list(), list()], before: [list(), list(), list()], w: list(), whole: false }
    }

    fn fill(&mut self, j: usize, view: &View<T>, before: &[[T; 4]]) {
        let range = j * view.width..(j + 1) * view.width;
        let holes = view.holes.get(range.clone()).unwrap_or(&[]);
        self.whole = holes.iter().all(|h| *h == 0);
        let Row { now: [x, y, z], w, .. } = self;
        let row = &view.now[range.clone()];
        for ((((p, x), y), z), w) in row.iter().zip(x).zip(y).zip(z).zip(w) {
            [*x, *y, *z, *w] = *p;
        }
        self.whole &= row.iter().all(|p| p[3] >= T::of(0.0));
        let [x, y, z] = &mut self.before;
        for (((p, x), y), z) in before.get(range).unwrap_or(&[]).iter().zip(x).zip(y).zip(z) {
            [*x, *y, *z, _] = *p;
        }
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
    fn fill<K: Machine<T>>(&mut self, k: K, facets: &impl Facets<T>, upper: &Row<T>, lower: &Row<T>, width: usize) {
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

impl<T: Real, F: Facets<T>> Work<T> for Chunk<'_, '_, T, F> {
    #[inline(always)]
    fn run<K: Machine<T>>(self, k: K) {
        let Chunk { facets, view, before, first, results } = self;
        let (width, height) = (view.width, view.now.len() / view.width);
        let [mut above, mut here, mut below] = [0; 3].map(|_| Row::new(width));
        let [mut over, mut under] = [0; 2].map(|_| Quads::new(width));
        here.fill(first, &view, before);
        above.whole = true;
        if first > 0 {
            above.fill(first - 1, &view, before);
            over.fill(k, &facets, &above, &here, width);
        }
        for (n, results) in results.chunks_exact_mut(width).enumerate() {
            let j = first + n;
            if j + 1 < height {
                below.fill(j + 1, &view, before);
                under.fill(k, &facets, &here, &below, width);
            } else {
                (below.whole, ()) = (true, under.clear());
            }
            if above.whole && here.whole && below.whole {
                row(k, &facets, (&over, &under), &here.w, results);
            } else {
                results.iter_mut().enumerate().for_each(|(i, result)| *result = facets.alone(i, j));
            }
            std::mem::swap(&mut over, &mut under);
            std::mem::swap(&mut above, &mut here);
            std::mem::swap(&mut here, &mut below);
        }
    }
}

/// The particles between two rows of quads.
#[inline(always)]
fn row<T: Real, K: Machine<T>>(
    k: K,
    facets: &impl Facets<T>,
    (over, under): (&Quads<T>, &Quads<T>),
    w: &[T],
    results: &mut [[T; 4]],
) {
    for (n, results) in results.chunks_mut(K::WIDE).enumerate() {
        let at = n * K::WIDE;
        let above = k.plus(k.loads(&over.left, at + 1), k.loads(&over.both, at));
        let below = k.plus(k.loads(&under.both, at + 1), k.loads(&under.right, at));
        let of = facets.particle(k, k.plus(above, below), k.load(w, at));
        let mut lists = [[T::of(0.0); LANES]; 4];
        for (list, v) in lists.iter_mut().zip(of) {
            k.store(list, 0, v);
        }
        let [x, y, z, w] = &lists;
        for (result, (((x, y), z), w)) in results.iter_mut().zip(x.iter().zip(y).zip(z).zip(w)) {
            *result = [*x, *y, *z, *w];
        }
    }
}
