//! Twin of shaders/leaves.wgsl: boxes around the particles of each tile, and how far these may move until the next search.
//!
//! Beside them, on the CPU alone, are boxes of normals: they tell where cloth is so flat that it cannot touch itself.

use super::meeting::tiles::{LANES_OF_TILE, SIDE, Tiles, lane};
use super::tree::{Node, Tree};
use crate::number::real::{Real, cross, dot, scale, sub};
use crate::passes::SEARCH_STEPS;

/// Share of the contact distance that a particle may move before partners are searched again: at least, so that cloth at rest
/// keeps its lists, and at most, so that lists stay short.
pub const MIN_REACH: f64 = 0.1;
pub const MAX_REACH: f64 = 0.35;
/// Steps of the present speed that a particle may go until the next search.
pub const STEPS_AHEAD: f64 = 1.5 * SEARCH_STEPS as f64;

/// Makes the boxes of all tiles.
pub fn run<T: Real>(tree: &mut Tree<T>, tiles: &Tiles<T>, distance: T) {
    for tile in 0..tiles.count() {
        (tree.reach[tile], tree.nodes[tile]) = around(tiles, tile, distance);
    }
    for c in 0..3 {
        tree.at[c].copy_from_slice(&tiles.now[c]);
    }
}

/// The reach of the particles of a tile, and their box.
fn around<T: Real>(tiles: &Tiles<T>, tile: usize, distance: T) -> (T, Node<T>) {
    let (mut node, mut fastest) = (Node::<T>::none(), T::of(0.0));
    for place in tile * LANES_OF_TILE..(tile + 1) * LANES_OF_TILE {
        if tiles.texel[place] == u32::MAX {
            continue;
        }
        let p = Tiles::at(&tiles.now, place);
        let step = sub(p, Tiles::at(&tiles.was, place));
        fastest = fastest.max(dot(step, step));
        let point = Node { low: p, high: p, ..Node::none() };
        node = node.with(&point);
    }
    let ahead = fastest.sqrt() * T::of(STEPS_AHEAD);
    let reach = ahead.max(distance * T::of(MIN_REACH)).min(distance * T::of(MAX_REACH));
    let wide = distance * T::of(0.5) + reach;
    for c in 0..3 {
        node.low[c] = node.low[c] - wide;
        node.high[c] = node.high[c] + wide;
    }
    turns(tiles, tile, &mut node);
    (reach, node)
}

/// The bounds of the normals of four quads of a tile; all normals where it has no whole quad.
fn turns<T: Real>(tiles: &Tiles<T>, tile: usize, node: &mut Node<T>) {
    let first = tile * LANES_OF_TILE;
    let mut any = false;
    for (i, j) in [(0, 0), (SIDE - 2, 0), (0, SIDE - 2), (SIDE - 2, SIDE - 2)] {
        let corners = [(i, j), (i + 1, j), (i, j + 1), (i + 1, j + 1)].map(|(i, j)| first + lane(i, j));
        if corners.iter().any(|place| tiles.texel[*place] == u32::MAX) {
            continue;
        }
        let [a, b, c, d] = corners.map(|place| Tiles::at(&tiles.now, place));
        let normal = cross(sub(d, a), sub(c, b));
        let long = dot(normal, normal).sqrt();
        if long > T::of(0.0) {
            let normal = scale(normal, T::of(1.0) / long);
            (0..3).for_each(|c| node.turn_low[c] = node.turn_low[c].min(normal[c]));
            (0..3).for_each(|c| node.turn_high[c] = node.turn_high[c].max(normal[c]));
            any = true;
        }
    }
    if !any {
        (node.turn_low, node.turn_high) = ([T::of(-1.0); 3], [T::of(1.0); 3]);
    }
}
