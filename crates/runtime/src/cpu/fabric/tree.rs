//! Twin of shaders/tree.wgsl: boxes around 2 x 2 boxes, level by level, from those of tiles up.
//!
//! They are the minima and maxima of the mip chain of the position image: refitted without a sort.

use super::drift::{Drift, Places};
use super::meeting::tiles::{LANES_OF_TILE, Tiles};
use crate::memory::Tally;
use crate::number::real::{Real, V3};

/// Bounds of particles.
#[derive(Clone, Copy, Debug)]
pub struct Node<T> {
    /// \[m\], with half the distance and the reach of each particle.
    pub low: V3<T>,
    pub high: V3<T>,
}

/// The boxes of one sheet on one level.
#[derive(Clone, Copy, Debug)]
pub struct Level {
    pub first: usize,
    pub columns: usize,
    pub rows: usize,
}

impl Level {
    /// This level and those above it, up to one box; the boxes above lie from `end` on, which goes on behind them.
    pub fn up(self, end: &mut usize) -> Vec<Level> {
        let mut levels = vec![self];
        let mut level = self;
        while level.columns.max(level.rows) > 1 {
            level = Level { first: *end, columns: level.columns.div_ceil(2), rows: level.rows.div_ceil(2) };
            *end += level.columns * level.rows;
            levels.push(level);
        }
        levels
    }
}

/// The boxes of all sheets; those of tiles come first, as the tiles do.
pub struct Tree<T: Real> {
    pub nodes: Vec<Node<T>>,
    /// For each sheet, from its tiles to the box of all of it.
    pub sheets: Vec<Vec<Level>>,
    /// How far \[m\] particles of a tile may move until the next search.
    pub reach: Vec<T>,
    /// How far they have moved since the last search.
    pub drift: Drift<T>,
    /// Where particles were at the last search.
    pub at: Vec<Places<T>>,
}

impl<T: Real> Node<T> {
    /// Around nothing.
    pub fn none() -> Self {
        let far = T::of(f64::from(f32::MAX));
        Node { low: [far; 3], high: [-far; 3] }
    }

    /// Around both.
    #[inline(always)]
    pub fn with(&self, other: &Self) -> Self {
        let least = |a: V3<T>, b: V3<T>| [a[0].min(b[0]), a[1].min(b[1]), a[2].min(b[2])];
        let most = |a: V3<T>, b: V3<T>| [a[0].max(b[0]), a[1].max(b[1]), a[2].max(b[2])];
        Node { low: least(self.low, other.low), high: most(self.high, other.high) }
    }

    /// Whether particles of both may meet.
    #[inline(always)]
    pub fn meets(&self, other: &Self) -> bool {
        (0..3).all(|c| self.low[c] <= other.high[c] && other.low[c] <= self.high[c])
    }
}

impl<T: Real> Tree<T> {
    /// Room for the boxes of tiles.
    pub fn new(tiles: &Tiles<T>) -> Self {
        let (mut sheets, mut end) = (Vec::new(), tiles.count());
        for grid in &tiles.grids {
            sheets.push(Level { first: grid.first, columns: grid.columns, rows: grid.rows }.up(&mut end));
        }
        let at = vec![[[T::of(0.0); LANES_OF_TILE]; 3]; tiles.count()];
        Tree {
            nodes: vec![Node::none(); end],
            sheets,
            reach: vec![T::of(-1.0); tiles.count()],
            drift: Drift::new(tiles.count()),
            at,
        }
    }

    /// Numbers that it takes.
    pub fn tally(&self, tally: &mut Tally) {
        tally.state(&self.nodes);
        tally.state(&self.reach);
        tally.state(self.drift.list());
        tally.state(&self.at);
    }
}

/// Makes all boxes above those of tiles.
pub fn run<T: Real>(tree: &mut Tree<T>) {
    for levels in &tree.sheets {
        for pair in levels.windows(2) {
            let (below, level) = (pair[0], pair[1]);
            for n in 0..level.columns * level.rows {
                let (i, j) = (2 * (n % level.columns), 2 * (n / level.columns));
                let mut node = Node::<T>::none();
                for row in j..(j + 2).min(below.rows) {
                    for column in i..(i + 2).min(below.columns) {
                        node = node.with(&tree.nodes[below.first + row * below.columns + column]);
                    }
                }
                tree.nodes[level.first + n] = node;
            }
        }
    }
}
