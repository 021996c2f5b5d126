//! Boxes around cells with the reach of their points, around tiles of 4 x 4 cells, and level by level above those.

use super::spread::Spread;
use super::surface::{Patch, Surface};
use super::tiles::{SIDE, Tile};
use crate::cpu::fabric::tree::Level;
use crate::number::lanes::LANES;
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
    /// For each patch the boxes from tiles up; the tiles themselves lie one patch after the other.
    pub levels: Vec<Vec<Level>>,
    pub tiles: Vec<Tile>,
    first_tiles: Vec<usize>,
    pub patches: Vec<Patch>,
}

/// A box: its patch, its level, its column and its row.
#[derive(Clone, Copy)]
pub struct Node {
    pub patch: usize,
    pub level: usize,
    pub column: usize,
    pub row: usize,
}

impl Boxes {
    /// Room for those of a surface.
    pub fn new(surface: &Surface) -> Self {
        let (mut levels, mut first_tiles, mut tiles) = (Vec::new(), Vec::new(), 0);
        let mut end = surface.corners.len();
        for patch in &surface.patches {
            let first = end;
            let (columns, rows) = (patch.width.div_ceil(SIDE), patch.height.div_ceil(SIDE));
            end += columns * rows;
            levels.push(Level { first, columns, rows }.up(&mut end));
            first_tiles.push(tiles);
            tiles += columns * rows;
        }
        Boxes {
            bounds: vec![Bound::NONE; end],
            spreads: vec![Spread::NONE; end],
            floor: 0.0,
            levels,
            tiles: vec![
                [
                    [f32::MAX; LANES],
                    [f32::MAX; LANES],
                    [f32::MAX; LANES],
                    [-f32::MAX; LANES],
                    [-f32::MAX; LANES],
                    [-f32::MAX; LANES]
                ];
                tiles
            ],
            first_tiles,
            patches: surface.patches.clone(),
        }
    }

    /// Makes all boxes above those of cells.
    pub fn refit(&mut self) {
        for patch in 0..self.levels.len() {
            for level in 0..self.levels[patch].len() {
                let Level { columns, rows, .. } = self.levels[patch][level];
                for (row, column) in (0..rows).flat_map(|row| (0..columns).map(move |column| (row, column))) {
                    self.join(Node { patch, level, column, row });
                }
            }
        }
    }

    /// The same for boxes above some cells: patches, rows and columns.
    pub fn refit_above(&mut self, cells: &mut Vec<[usize; 3]>) {
        let mut by = SIDE;
        for level in 0.. {
            cells.iter_mut().for_each(|[_, row, column]| (*row, *column) = (*row / by, *column / by));
            cells.sort_unstable();
            cells.dedup();
            cells.retain(|[patch, ..]| level < self.levels[*patch].len());
            if cells.is_empty() {
                return;
            }
            cells.iter().for_each(|[patch, row, column]| {
                self.join(Node { patch: *patch, level, column: *column, row: *row });
            });
            by = 2;
        }
    }

    /// Makes a box from those below it.
    fn join(&mut self, node: Node) {
        let (mut bound, mut spread) = (Bound::NONE, Spread::NONE);
        if node.level == 0 {
            let patch = self.patches[node.patch];
            let tile = self.tile(node);
            for row in 0..SIDE.min(patch.height - SIDE * node.row) {
                for column in 0..SIDE.min(patch.width - SIDE * node.column) {
                    let cell = patch.first + (SIDE * node.row + row) * patch.width + SIDE * node.column + column;
                    let of = &self.bounds[cell];
                    (bound, spread) = (bound.with(of), spread.with(&self.spreads[cell]));
                    for c in 0..3 {
                        self.tiles[tile][c][SIDE * row + column] = of.low[c];
                        self.tiles[tile][3 + c][SIDE * row + column] = of.high[c];
                    }
                }
            }
        } else {
            let (nodes, count) = self.below(node);
            for below in nodes[..count].iter().map(|below| self.index(*below)) {
                (bound, spread) = (bound.with(&self.bounds[below]), spread.with(&self.spreads[below]));
            }
        }
        let at = self.index(node);
        (self.bounds[at], self.spreads[at]) = (bound, spread);
    }

    pub fn top(&self, patch: usize) -> Node {
        Node { patch, level: self.levels[patch].len() - 1, column: 0, row: 0 }
    }

    pub fn index(&self, node: Node) -> usize {
        let level = self.levels[node.patch][node.level];
        level.first + node.row * level.columns + node.column
    }

    pub fn tile(&self, node: Node) -> usize {
        self.first_tiles[node.patch] + node.row * self.levels[node.patch][0].columns + node.column
    }

    pub fn below(&self, node: Node) -> ([Node; 4], usize) {
        let level = self.levels[node.patch][node.level - 1];
        let (mut nodes, mut count) = ([node; 4], 0);
        for row in 2 * node.row..(2 * node.row + 2).min(level.rows) {
            for column in 2 * node.column..(2 * node.column + 2).min(level.columns) {
                nodes[count] = Node { level: node.level - 1, column, row, ..node };
                count += 1;
            }
        }
        (nodes, count)
    }
}
