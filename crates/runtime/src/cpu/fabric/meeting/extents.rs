//! Twin of shaders/extents.wgsl: boxes around all that the particles of each tile pass until the next search for particles of other cloths.

use super::shadow::Shadow;
use super::tiles::{LANES_OF_TILE, Tiles};
use crate::cpu::fabric::tree::Node;
use crate::number::real::{Real, add, scale};

/// How much larger boxes are than what particles pass, as a share of the contact distance: half of it, and a quarter for pushes.
pub const WIDTH: f64 = 0.75;

/// The box of a tile.
pub fn around<T: Real>(shadow: &Shadow<T>, tiles: &Tiles<T>, tile: usize) -> Node<T> {
    let (mut node, wide) = (Node::<T>::none(), shadow.distance * T::of(WIDTH));
    for place in (tile * LANES_OF_TILE..(tile + 1) * LANES_OF_TILE).filter(|place| tiles.texel[*place] != u32::MAX) {
        let at = shadow.at(place);
        let end = add(at, scale(shadow.velocity_at(place), shadow.length));
        for c in 0..3 {
            node.low[c] = node.low[c].min(at[c]).min(end[c]);
            node.high[c] = node.high[c].max(at[c]).max(end[c]);
        }
    }
    for c in 0..3 {
        (node.low[c], node.high[c]) = (node.low[c] - wide, node.high[c] + wide);
    }
    node
}
