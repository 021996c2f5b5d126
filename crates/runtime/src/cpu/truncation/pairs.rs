//! The pairs of cells whose boxes meet, from the boxes of whole patches down.

use super::boxes::{Boxes, Node};
use super::surface::Patch;
use super::tiles::{Meets, MeetsOne, SIDE};
use crate::number::lanes::{LANES, widest};

/// Two cells, the column and the row of the first, and how many columns and rows the second is from it; `None` for cells of different patches.
pub struct CellPair {
    pub cells: [usize; 2],
    pub patch: usize,
    pub spot: [usize; 2],
    pub apart: Option<[isize; 2]>,
}

impl Boxes {
    /// Calls `each` with every pair of cells whose features may meet, a cell with itself too, always in the same order.
    pub fn pairs(&self, mut each: impl FnMut(CellPair)) {
        for patch in 0..self.levels.len() {
            self.within(self.top(patch), &mut each);
            (patch + 1..self.levels.len()).for_each(|other| self.across(self.top(patch), self.top(other), &mut each));
        }
    }

    /// The same for the pairs of one cell, in the same order for the same boxes.
    pub fn pairs_of(&self, patch: &Patch, cell: usize, mut each: impl FnMut(CellPair)) {
        let spot = patch.spot(cell);
        (0..self.levels.len()).for_each(|other| self.one((patch.index, spot, cell), self.top(other), &mut each));
    }

    fn within(&self, node: Node, each: &mut impl FnMut(CellPair)) {
        if self.spreads[self.index(node)].is_apart(self.floor) {
            return;
        }
        if node.level == 0 {
            return self.compare(node, node, each);
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
            return self.compare(a, b, each);
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

    /// Pairs of the cells of two tiles, or of one tile.
    fn compare(&self, a: Node, b: Node, each: &mut impl FnMut(CellPair)) {
        let mut hits = [[0; LANES]; LANES];
        let (one, other) = (&self.tiles[self.tile(a)], &self.tiles[self.tile(b)]);
        let both = self.bounds[self.index(b)];
        widest(Meets { one, other, both, hits: &mut hits });
        let same = (a.patch, a.row, a.column) == (b.patch, b.row, b.column);
        for (lane, hits) in hits.iter().enumerate() {
            let mut hits = u128::from_le_bytes(*hits);
            if same {
                hits &= u128::MAX << (8 * lane);
            }
            if hits != 0 {
                let spot = [SIDE * a.column + lane % SIDE, SIDE * a.row + lane / SIDE];
                let patch = &self.patches[a.patch];
                let cell = patch.first + spot[1] * patch.width + spot[0];
                self.found((a.patch, spot, cell), b, hits, each);
            }
        }
    }

    /// Pairs of a cell with those of a tile that have a byte that is not zero.
    fn found(
        &self,
        (patch, spot, cell): (usize, [usize; 2], usize),
        tile: Node,
        mut hits: u128,
        each: &mut impl FnMut(CellPair),
    ) {
        let other = &self.patches[tile.patch];
        while hits != 0 {
            let lane = hits.trailing_zeros() as usize / 8;
            hits &= hits - 1;
            let [i, j] = [SIDE * tile.column + lane % SIDE, SIDE * tile.row + lane / SIDE];
            let apart = [i as isize - spot[0] as isize, j as isize - spot[1] as isize];
            let apart = (patch == tile.patch).then_some(apart);
            each(CellPair { cells: [cell, other.first + j * other.width + i], patch, spot, apart });
        }
    }

    /// Pairs of one cell with those below a box.
    fn one(&self, cell: (usize, [usize; 2], usize), node: Node, each: &mut impl FnMut(CellPair)) {
        let bound = &self.bounds[cell.2];
        if !bound.meets(&self.bounds[self.index(node)]) {
            return;
        }
        if node.level > 0 {
            let (nodes, count) = self.below(node);
            nodes[..count].iter().for_each(|node| self.one(cell, *node, each));
            return;
        }
        let mut hits = [0; LANES];
        widest(MeetsOne { bound, tile: &self.tiles[self.tile(node)], hits: &mut hits });
        self.found(cell, node, u128::from_le_bytes(hits), each);
    }
}
