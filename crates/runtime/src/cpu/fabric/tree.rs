//! Twin of shaders/tree.wgsl: boxes around 2 x 2 boxes, level by level, from those of tiles up.
//!
//! They are the minima and maxima of the mip chain of the position image: refitted without a sort.

use super::meeting::tiles::{LANES_OF_TILE, SIDE, Tiles, corner};
use crate::memory::Tally;
use crate::number::aligned::Aligned;
use crate::number::real::{Real, V3, dot, sub};
use crate::passes::SEARCH_STEPS;

/// Bounds of particles, and of normals.
#[derive(Clone, Copy, Debug)]
pub struct Node<T> {
    /// \[m\], with half the distance and the reach of each particle.
    pub low: V3<T>,
    pub high: V3<T>,
    /// Of unit normals.
    pub turn_low: V3<T>,
    pub turn_high: V3<T>,
}

/// The boxes of one sheet on one level.
#[derive(Clone, Copy, Debug)]
pub struct Level {
    pub first: usize,
    pub columns: usize,
    pub rows: usize,
}

/// The boxes of all sheets; those of tiles come first, as the tiles do.
pub struct Tree<T: Real> {
    pub nodes: Vec<Node<T>>,
    /// For each sheet, from its tiles to the box of all of it.
    pub sheets: Vec<Vec<Level>>,
    /// How far \[m\] particles of a tile may move until the next search.
    pub reach: Vec<T>,
    /// Where particles were at the last search.
    pub at: [Aligned<T>; 3],
}

impl<T: Real> Node<T> {
    /// Around nothing.
    pub fn none() -> Self {
        let far = T::of(f64::from(f32::MAX));
        Node { low: [far; 3], high: [-far; 3], turn_low: [far; 3], turn_high: [-far; 3] }
    }

    /// Around both.
    #[inline(always)]
    pub fn with(&self, other: &Self) -> Self {
        let least = |a: V3<T>, b: V3<T>| [a[0].min(b[0]), a[1].min(b[1]), a[2].min(b[2])];
        let most = |a: V3<T>, b: V3<T>| [a[0].max(b[0]), a[1].max(b[1]), a[2].max(b[2])];
        Node {
            low: least(self.low, other.low),
            high: most(self.high, other.high),
            turn_low: least(self.turn_low, other.turn_low),
            turn_high: most(self.turn_high, other.turn_high),
        }
    }

    /// Whether particles of both may meet.
    #[inline(always)]
    pub fn meets(&self, other: &Self) -> bool {
        (0..3).all(|c| self.low[c] <= other.high[c] && other.low[c] <= self.high[c])
    }

    /// Whether all normals are within the angle from the middle of their box whose cosine is given.
    #[inline(always)]
    pub fn is_flat(&self, cosine: T) -> bool {
        let (mut square, mut spread) = (T::of(0.0), T::of(0.0));
        for c in 0..3 {
            let middle = (self.turn_low[c] + self.turn_high[c]) * T::of(0.5);
            let half = (self.turn_high[c] - self.turn_low[c]) * T::of(0.5);
            square = square + middle * middle;
            spread = spread + middle.abs() * half;
        }
        square - spread >= cosine * square.sqrt() && square > T::of(0.0)
    }
}

impl<T: Real> Tree<T> {
    /// Room for the boxes of tiles.
    pub fn new(tiles: &Tiles<T>) -> Self {
        let (mut sheets, mut end) = (Vec::new(), tiles.count());
        for grid in &tiles.grids {
            let mut level = Level { first: grid.first, columns: grid.columns, rows: grid.rows };
            let mut levels = vec![level];
            while level.columns.max(level.rows) > 1 {
                level = Level { first: end, columns: level.columns.div_ceil(2), rows: level.rows.div_ceil(2) };
                end += level.columns * level.rows;
                levels.push(level);
            }
            sheets.push(levels);
        }
        let at = std::array::from_fn(|_| Aligned::zeros(tiles.texel.len()));
        Tree { nodes: vec![Node::none(); end], sheets, reach: vec![T::of(-1.0); tiles.count()], at }
    }

    /// Numbers that it takes.
    pub fn tally(&self, tally: &mut Tally) {
        tally.state(&self.nodes);
        tally.state(&self.reach);
        self.at.iter().for_each(|list| tally.state(list));
    }

    /// Whether no particle leaves its reach in the next [`SEARCH_STEPS`] steps, if it goes on as in the last one.
    pub fn holds(&self, tiles: &Tiles<T>) -> bool {
        (0..tiles.count()).all(|tile| {
            let (mut far, mut ahead) = (T::of(0.0), T::of(0.0));
            for place in tile * LANES_OF_TILE..(tile + 1) * LANES_OF_TILE {
                let p = Tiles::at(&tiles.now, place);
                let (way, step) = (sub(p, Tiles::at(&self.at, place)), sub(p, Tiles::at(&tiles.was, place)));
                (far, ahead) = (far.max(dot(way, way)), ahead.max(dot(step, step)));
            }
            far.sqrt() + ahead.sqrt() * T::of(SEARCH_STEPS.into()) <= self.reach[tile]
        })
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

/// Cells between two places of a sheet, the larger of columns and rows.
#[inline(always)]
pub fn apart<T: Real>(tiles: &Tiles<T>, a: usize, b: usize) -> usize {
    let place = |n: usize| {
        let (spot, [i, j]) = (tiles.spots[n / LANES_OF_TILE], corner(n % LANES_OF_TILE));
        [spot.column as usize * SIDE + i, spot.row as usize * SIDE + j]
    };
    let (a, b) = (place(a), place(b));
    a[0].abs_diff(b[0]).max(a[1].abs_diff(b[1]))
}
