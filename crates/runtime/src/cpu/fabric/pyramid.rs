//! Twin of shaders/pyramid.wgsl: coarser grids of the same cloth, on which lengths are limited.
//!
//! A level has every other column and row of the one below it, and its last ones. Limits are sums of rest lengths along
//! the grid, so no level forbids what the cloth itself allows; they only act where they are passed, as folded cloth may be
//! as short as it likes. A node has the mass of the particles that it moves, so that free cloth keeps its momentum.
//! Nodes of both sides of a seam take one displacement ([`crate::levels::ties`]) before the next level goes on from there.

use std::sync::Arc;

use super::stretch::{self, Rests, Springs};
use super::{coarse_level, coarse_ties};
use crate::cpu::interpolate::{Field, Parted, add, interpolate};
use crate::cpu::rows::Threads;
use crate::cpu::sheet::{Sheet, Values};
use crate::levels::LevelGrid;
use crate::levels::ties::Ties;
use crate::number::aligned::Aligned;
use crate::number::real::{Real, scale};

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
    /// Particles or nodes of the grid below that do not follow all nodes around it.
    parted: Parted,
}

impl<T: Real> Pyramid<T> {
    /// Room for levels above a grid of `width` columns.
    pub fn new<U: Real>(grids: &[LevelGrid<U>], width: usize) -> Self {
        let mut below = width;
        let level = |g: &LevelGrid<U>| {
            let sheet = Sheet::new(&g.grid());
            let zero = T::of(0.0);
            let springs = [0, 1, 2, 3].map(|d| Springs {
                rest: Rests::List(Arc::new(sheet.list(zero, |k| T::of(g.limits[k][d].get())))),
                soft: Values::Constant(zero),
                sums: Vec::new(),
                bound: zero,
            });
            let weight = sheet.list(zero, |k| T::of(g.inverse_mass[k].into()));
            let parted = Parted::new(&g.links, std::mem::replace(&mut below, sheet.width));
            Level { origin: sheet.now.clone(), sheet, springs, weight, parted }
        };
        Pyramid { levels: grids.iter().map(level).collect() }
    }

    /// Nodes that could not move before a cut cannot after it.
    pub fn blind_as(mut self, before: &Self) -> Self {
        for (level, before) in self.levels.iter_mut().zip(&before.levels) {
            let nodes = level.weight.iter_mut().zip(&before.weight);
            nodes.filter(|(_, before)| **before <= T::of(0.0)).for_each(|(weight, _)| *weight = T::of(0.0));
        }
        self
    }

    /// Takes nodes from the particles.
    fn gather(&mut self, fine: &Sheet<T>) {
        for n in 0..self.levels.len() {
            let (below, rest) = self.levels.split_at_mut(n);
            let (now, w, width, half) = match below.last() {
                Some(l) => (&l.origin, &l.sheet.w, l.sheet.width, l.sheet.half),
                None => (&fine.now, &fine.w, fine.width, fine.half),
            };
            rest[0].gather(now, w, width, half);
        }
    }

    /// Moves level `n` (from 0 for the finest) with the one above, and limits its lengths.
    pub(super) fn limit(&mut self, threads: &Threads, present: &[bool; 4], n: usize) {
        let Some((here, above)) = self.levels.split_at_mut_checked(n + 1) else { return };
        let level = &mut here[n];
        if let Some(above) = above.first() {
            let Sheet { width, height, half, now, w, .. } = &mut level.sheet;
            interpolate([*width, *height], *half, &above.field(), |j, from, to| {
                add(&mut now[j * 6 * *half..], &w[j * 2 * *half..], *half, from, to, T::of(1.0));
            });
        }
        level.limit(threads, present);
    }

    /// The displacement of the finest level.
    pub fn field(&self) -> Option<Field<'_, T>> {
        self.levels.first().map(Level::field)
    }
}

/// The work of a pass of the pyramid.
#[derive(Clone, Copy)]
pub struct Descent<'a> {
    /// The directions of springs that any grid has.
    pub present: &'a [bool; 4],
    /// Only nodes that are duplicates are tied.
    pub cut: bool,
    /// The last level, 1 for the finest of all.
    pub finest: usize,
}

/// Limits lengths from the coarsest level to the last one.
pub fn run<T: Real>(
    pyramids: &mut [Pyramid<T>],
    sheets: &[Sheet<T>],
    threads: &Threads,
    Descent { present, cut, finest }: Descent,
    ties: &[Ties],
) {
    pyramids.iter_mut().zip(sheets).for_each(|(p, sheet)| p.gather(sheet));
    let most = pyramids.iter().map(|p| p.levels.len()).max().unwrap_or(0);
    for level in (finest..=most).rev() {
        coarse_level::run(pyramids, threads, present, level);
        coarse_ties::run(pyramids, level, cut, ties);
    }
}

/// Nodes of a level, of any grid, take the mean of their displacements by mass, or stay where one is pinned.
pub(super) fn tie<T: Real>(pyramids: &mut [Pyramid<T>], n: usize, tied: &[(usize, usize)]) {
    let (mut sum, mut mass, mut pinned) = ([T::of(0.0); 3], T::of(0.0), false);
    for (grid, k) in tied {
        let Level { sheet, origin, .. } = &pyramids[*grid].levels[n];
        let (at, w) = (sheet.triple(*k), sheet.w[sheet.single(*k)]);
        let weight = T::of(1.0) / w.max(T::of(1e-30));
        (0..3).for_each(|c| {
            sum[c] = sum[c] + (sheet.now[at + 2 * c * sheet.half] - origin[at + 2 * c * sheet.half]) * weight
        });
        (mass, pinned) = (mass + weight, pinned || w <= T::of(0.0));
    }
    let by = if pinned { [T::of(0.0); 3] } else { scale(sum, T::of(1.0) / mass.max(T::of(1e-30))) };
    for (grid, k) in tied {
        let Level { sheet, origin, .. } = &mut pyramids[*grid].levels[n];
        let (at, half) = (sheet.triple(*k), sheet.half);
        (0..3).for_each(|c| sheet.now[at + 2 * c * half] = origin[at + 2 * c * half] + by[c]);
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

    /// How far nodes have moved.
    fn field(&self) -> Field<'_, T> {
        let Sheet { width, height, half, now, .. } = &self.sheet;
        let moved = [0, 1, 2].map(|c| {
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
        });
        Field { moved, nodes: *width, parted: &self.parted }
    }
}
