//! Twin of shaders/pyramid.wgsl: coarser grids of the same cloth, on which lengths are limited.
//!
//! A level has every other column and row of the one below it, and its last ones. Limits are sums of rest lengths along
//! the grid, so no level forbids what the cloth itself allows; they only act where they are passed, as folded cloth may be
//! as short as it likes. A node has the mass of the particles that it moves, so that free cloth keeps its momentum.

use super::aligned::Aligned;
use super::real::Real;
use super::rows::Threads;
use super::sheet::{Sheet, Values};
use super::stretch::{self, Springs};
use crate::levels::{LevelGrid, span};

/// The levels of a sheet, finest first.
pub struct Pyramid<T: Real> {
    levels: Vec<Level<T>>,
}

struct Level<T: Real> {
    sheet: Sheet<T>,
    springs: [Springs<T>; 4],
    /// Where nodes were, as `sheet.now`.
    origin: Aligned<T>,
    /// Inverse mass \[1/kg\] of nodes that are not pinned, as `sheet.w`.
    weight: Vec<T>,
}

impl<T: Real> Pyramid<T> {
    /// Room for levels.
    pub fn new(grids: &[LevelGrid]) -> Self {
        let level = |g: &LevelGrid| {
            let sheet = Sheet::new(&g.grid());
            let zero = T::of(0.0);
            let springs = [0, 1, 2, 3].map(|d| Springs {
                rest: Values::List(sheet.list(zero, |k| T::of(g.limits[k][d].into()))),
                soft: Values::Constant(zero),
                sums: Vec::new(),
                bound: zero,
            });
            let weight = sheet.list(zero, |k| T::of(g.inverse_mass[k].into()));
            Level { origin: sheet.now.clone(), sheet, springs, weight }
        };
        Pyramid { levels: grids.iter().map(level).collect() }
    }

    /// Limits lengths from the coarsest level to the finest; the displacement of that one is then in it.
    pub fn run(&mut self, threads: &Threads, fine: &Sheet<T>, present: &[bool; 4]) {
        for n in 0..self.levels.len() {
            let (below, rest) = self.levels.split_at_mut(n);
            let (now, w, width, half) = match below.last() {
                Some(l) => (&l.origin, &l.sheet.w, l.sheet.width, l.sheet.half),
                None => (&fine.now, &fine.w, fine.width, fine.half),
            };
            rest[0].gather(now, w, width, half);
        }
        for n in (0..self.levels.len()).rev() {
            let (here, above) = self.levels.split_at_mut(n + 1);
            let level = &mut here[n];
            if let Some(above) = above.first() {
                let moved = above.moved();
                let Sheet { width, height, half, now, w, .. } = &mut level.sheet;
                refine((*width, *height, *half), &moved, above.sheet.width, |j, from, to| {
                    add(&mut now[j * 6 * *half..], &w[j * 2 * *half..], *half, from, to, T::of(1.0));
                });
            }
            level.limit(threads, present);
        }
    }

    /// The displacement of the finest level, as three lists row by row, and its width.
    pub fn moved(&self) -> Option<([Vec<T>; 3], usize)> {
        self.levels.first().map(|l| (l.moved(), l.sheet.width))
    }
}

impl<T: Real> Level<T> {
    /// Takes nodes from the level below.
    fn gather(&mut self, below: &[T], w: &[T], width: usize, half: usize) {
        let sheet = &mut self.sheet;
        let (nodes, wide) = (sheet.width, sheet.half);
        // Node i is the i-th even column; the last one may be an odd column.
        let take = |to: &mut [T], from: &[T]| {
            let (even, odd) = to.split_at_mut(wide);
            let pairs = from[..half].as_chunks::<2>().0;
            even.iter_mut().zip(pairs).for_each(|(x, pair)| *x = pair[0]);
            odd.iter_mut().zip(pairs).for_each(|(x, pair)| *x = pair[1]);
            let last = nodes - 1;
            let column = (2 * last).min(width - 1);
            to[(last & 1) * wide + last / 2] = from[(column & 1) * half + column / 2];
        };
        let rows = below.len() / (6 * half);
        for j in 0..sheet.height {
            let row = (2 * j).min(rows - 1);
            for c in 0..3 {
                take(
                    &mut sheet.now[(j * 3 + c) * 2 * wide..][..2 * wide],
                    &below[(row * 3 + c) * 2 * half..][..2 * half],
                );
            }
            let here = j * 2 * wide..(j + 1) * 2 * wide;
            let inverse_mass = &mut sheet.w[here.clone()];
            take(inverse_mass, &w[row * 2 * half..(row + 1) * 2 * half]);
            for (w, weight) in inverse_mass.iter_mut().zip(&self.weight[here]) {
                *w = if *w > T::of(0.0) { *weight } else { T::of(0.0) };
            }
        }
        self.origin.copy_from_slice(&sheet.now);
    }

    fn limit(&mut self, threads: &Threads, present: &[bool; 4]) {
        for direction in [2, 3, 0, 1].into_iter().filter(|d| present[*d as usize]) {
            for parity in 0..2 {
                stretch::limit(threads, &mut self.sheet, &mut self.springs[direction as usize], direction, parity);
            }
        }
    }

    /// How far nodes have moved, row by row.
    fn moved(&self) -> [Vec<T>; 3] {
        let Sheet { width, height, half, now, .. } = &self.sheet;
        [0, 1, 2].map(|c| {
            let mut out = vec![T::of(0.0); width * height];
            for (j, row) in out.chunks_exact_mut(*width).enumerate() {
                let first = (j * 3 + c) * 2 * half;
                let (now, origin) = (&now[first..first + 2 * half], &self.origin[first..first + 2 * half]);
                for side in 0..2 {
                    let planes = now[side * half..].iter().zip(&origin[side * half..]);
                    row[side..].iter_mut().step_by(2).zip(planes).for_each(|(x, (a, b))| *x = *a - *b);
                }
            }
            out
        })
    }
}

/// For every row of a finer grid the displacement of its even and odd columns, by means of the nodes around.
pub fn refine<T: Real>(
    (width, height, half): (usize, usize, usize),
    moved: &[Vec<T>; 3],
    nodes: usize,
    mut each: impl FnMut(usize, &[Vec<T>; 3], &[Vec<T>; 3]),
) {
    let half_of = T::of(0.5);
    let mut even = [0; 3].map(|_| vec![T::of(0.0); half]);
    let mut odd = even.clone();
    for j in 0..height {
        let (a, b) = span(j, height);
        for c in 0..3 {
            let (above, below) = (&moved[c][a * nodes..(a + 1) * nodes], &moved[c][b * nodes..(b + 1) * nodes]);
            let means = &mut even[c][..nodes];
            for ((mean, a), b) in means.iter_mut().zip(above).zip(below) {
                *mean = half_of * (*a + *b);
            }
            let between = odd[c].iter_mut().zip(means.windows(2)).take((width - 1) / 2);
            between.for_each(|(x, ends)| *x = half_of * (ends[0] + ends[1]));
            if width % 2 == 0 {
                // The last column is a node. It is no even one.
                odd[c][width / 2 - 1] = means[nodes - 1];
                means[nodes - 1] = T::of(0.0);
            }
        }
        each(j, &even, &odd);
    }
}

/// Adds displacements to a row of particles that are not pinned.
pub fn add<T: Real>(row: &mut [T], w: &[T], half: usize, even: &[Vec<T>; 3], odd: &[Vec<T>; 3], share: T) {
    for c in 0..3 {
        for (side, from) in [even, odd].into_iter().enumerate() {
            let row = &mut row[(c * 2 + side) * half..][..half];
            let w = &w[side * half..][..half];
            for ((x, w), more) in row.iter_mut().zip(w).zip(&from[c]) {
                *x = *x + if *w > T::of(0.0) { *more * share } else { T::of(0.0) };
            }
        }
    }
}
