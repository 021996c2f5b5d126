//! Twin of shaders/leaves.wgsl: boxes around the particles of each tile, and how far these may move until the next search.

use super::meeting::tiles::{LANES_OF_TILE, Tiles};
use super::tree::{Node, Tree};
use crate::number::real::{Real, dot, sub};
use crate::passes::SEARCH_STEPS;

/// Share of the contact distance that a particle may move before partners are searched again: at least, so that cloth at rest
/// keeps its lists, and at most, so that lists stay short.
pub const MIN_REACH: f64 = 0.1;
pub const MAX_REACH: f64 = 0.3;
/// Steps of the present speed that a particle may go until the next search.
pub const STEPS_AHEAD: f64 = 1.5 * SEARCH_STEPS as f64;

/// Makes the boxes of all tiles, each wide enough for particles to meet those that are nearer than `width` \[m\] of its tile.
pub fn run<T: Real>(tree: &mut Tree<T>, tiles: &Tiles<T>, distance: T, width: impl Fn(usize) -> T) {
    for tile in 0..tiles.count() {
        (tree.reach[tile], tree.nodes[tile]) = around(tiles, tile, distance, width(tile));
    }
    for (at, block) in tree.at.iter_mut().zip(&tiles.blocks) {
        *at = block.now;
    }
    tree.drift.begin();
}

/// The reach of the particles of a tile, and their box.
fn around<T: Real>(tiles: &Tiles<T>, tile: usize, distance: T, width: T) -> (T, Node<T>) {
    let (mut node, mut fastest) = (Node::<T>::none(), T::of(0.0));
    for place in tile * LANES_OF_TILE..(tile + 1) * LANES_OF_TILE {
        if tiles.texel[place] == u32::MAX {
            continue;
        }
        let p = tiles.now(place);
        let step = sub(p, tiles.was(place));
        fastest = fastest.max(dot(step, step));
        node = node.with(&Node { low: p, high: p });
    }
    let ahead = fastest.sqrt() * T::of(STEPS_AHEAD);
    let reach = ahead.max(distance * T::of(MIN_REACH)).min(distance * T::of(MAX_REACH));
    let wide = width * T::of(0.5) + reach;
    for c in 0..3 {
        node.low[c] = node.low[c] - wide;
        node.high[c] = node.high[c] + wide;
    }
    (reach, node)
}
