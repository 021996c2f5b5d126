//! Boxes around cells with the reach of their points, level by level, and the pairs of cells whose boxes meet.

use super::spread::Spread;
use super::surface::Surface;
use crate::cpu::fabric::tree::Level;
use crate::number::real::{V3, dot};

/// Bounds \[m\].
#[derive(Clone, Copy, Debug)]
pub struct Bound {
    pub low: V3<f32>,
    pub high: V3<f32>,
}

impl Bound {
    /// Around nothing.
    pub const NONE: Bound = Bound { low: [f32::MAX; 3], high: [-f32::MAX; 3] };

    pub fn with(&self, other: &Bound) -> Bound {
        let (a, b) = (self, other);
        let low = [0, 1, 2].map(|c| a.low[c].min(b.low[c]));
        Bound { low, high: [0, 1, 2].map(|c| a.high[c].max(b.high[c])) }
    }

    /// The center, and the distance of corners from it.
    #[inline]
    pub fn ball(&self) -> (V3<f32>, f32) {
        let half = [0, 1, 2].map(|c| 0.5 * (self.high[c] - self.low[c]));
        ([0, 1, 2].map(|c| 0.5 * (self.low[c] + self.high[c])), dot(half, half).sqrt())
    }

    /// Whether both share a point.
    #[inline(always)]
    pub fn meets(&self, other: &Bound) -> bool {
        (self.low[0] <= other.high[0])
            & (other.low[0] <= self.high[0])
            & (self.low[1] <= other.high[1])
            & (other.low[1] <= self.high[1])
            & (self.low[2] <= other.high[2])
            & (other.low[2] <= self.high[2])
    }
}

/// The boxes of all patches; those of cells come first, as the cells do.
#[derive(Default)]
pub struct Boxes {
    pub bounds: Vec<Bound>,
    pub spreads: Vec<Spread>,
    /// Least gap of features \[m\].
    pub floor: f32,
    patches: Vec<Vec<Level>>,
}

/// A box: its patch, its level, its column and its row.
#[derive(Clone, Copy)]
struct Node {
    patch: usize,
    level: usize,
    column: usize,
    row: usize,
}

/// Two cells, and how many columns and rows the second is from the first; `None` for cells of different patches.
pub struct CellPair {
    pub cells: [usize; 2],
    pub patch: usize,
    pub apart: Option<[isize; 2]>,
}

impl Boxes {
    /// Room for those of a surface.
    pub fn new(surface: &Surface) -> Self {
        let (mut patches, mut end) = (Vec::new(), surface.corners.len());
        for patch in &surface.patches {
            patches.push(Level { first: patch.first, columns: patch.width, rows: patch.height }.up(&mut end));
        }
        let (bounds, spreads) = (vec![Bound::NONE; end], vec![Spread::NONE; end]);
        Boxes { bounds, spreads, floor: 0.0, patches }
    }

    /// Makes all boxes above those of cells.
    pub fn refit(&mut self) {
        for levels in &self.patches {
            for pair in levels.windows(2) {
                let (below, level) = (pair[0], pair[1]);
                for n in 0..level.columns * level.rows {
                    let (i, j) = (2 * (n % level.columns), 2 * (n / level.columns));
                    let (mut bound, mut spread) = (Bound::NONE, Spread::NONE);
                    for row in j..(j + 2).min(below.rows) {
                        for column in i..(i + 2).min(below.columns) {
                            let from = below.first + row * below.columns + column;
                            (bound, spread) = (bound.with(&self.bounds[from]), spread.with(&self.spreads[from]));
                        }
                    }
                    (self.bounds[level.first + n], self.spreads[level.first + n]) = (bound, spread);
                }
            }
        }
    }

    /// Calls `each` with every pair of cells whose features may meet, a cell with itself too, always in the same order.
    pub fn pairs(&self, mut each: impl FnMut(CellPair)) {
        for (patch, levels) in self.patches.iter().enumerate() {
            self.within(self.top(patch), &mut each);
            for other in patch + 1..self.patches.len() {
                self.across(Node { level: levels.len() - 1, ..self.top(patch) }, self.top(other), &mut each);
            }
        }
    }

    fn top(&self, patch: usize) -> Node {
        Node { patch, level: self.patches[patch].len() - 1, column: 0, row: 0 }
    }

    fn index(&self, node: Node) -> usize {
        let level = self.patches[node.patch][node.level];
        level.first + node.row * level.columns + node.column
    }

    fn below(&self, node: Node) -> ([Node; 4], usize) {
        let level = self.patches[node.patch][node.level - 1];
        let (mut nodes, mut count) = ([node; 4], 0);
        for row in 2 * node.row..(2 * node.row + 2).min(level.rows) {
            for column in 2 * node.column..(2 * node.column + 2).min(level.columns) {
                nodes[count] = Node { level: node.level - 1, column, row, ..node };
                count += 1;
            }
        }
        (nodes, count)
    }

    fn within(&self, node: Node, each: &mut impl FnMut(CellPair)) {
        if self.spreads[self.index(node)].is_apart(self.floor) {
            return;
        }
        if node.level == 0 {
            self.found(node, node, each);
            return;
        }
        let (nodes, count) = self.below(node);
        for n in 0..count {
            self.within(nodes[n], each);
            (n + 1..count).for_each(|m| self.across(nodes[n], nodes[m], each));
        }
    }

    /// Pairs of two boxes; the one on the higher level is divided first.
    fn across(&self, a: Node, b: Node, each: &mut impl FnMut(CellPair)) {
        let (m, n) = (self.index(a), self.index(b));
        if !self.bounds[m].meets(&self.bounds[n]) {
            return;
        }
        let beside =
            a.patch == b.patch && a.level == b.level && a.column.abs_diff(b.column) <= 1 && a.row.abs_diff(b.row) <= 1;
        if beside && self.spreads[m].with(&self.spreads[n]).is_apart(self.floor) {
            return;
        }
        if a.level == 0 && b.level == 0 {
            return self.found(a, b, each);
        }
        if a.level == b.level {
            let ((of_a, m), (of_b, n)) = (self.below(a), self.below(b));
            for a in &of_a[..m] {
                of_b[..n].iter().for_each(|b| self.across(*a, *b, each));
            }
        } else if a.level > b.level {
            let (nodes, count) = self.below(a);
            nodes[..count].iter().for_each(|a| self.across(*a, b, each));
        } else {
            let (nodes, count) = self.below(b);
            nodes[..count].iter().for_each(|b| self.across(a, *b, each));
        }
    }

    fn found(&self, a: Node, b: Node, each: &mut impl FnMut(CellPair)) {
        let apart = [b.column as isize - a.column as isize, b.row as isize - a.row as isize];
        let apart = (a.patch == b.patch).then_some(apart);
        each(CellPair { cells: [self.index(a), self.index(b)], patch: a.patch, apart });
    }
}
