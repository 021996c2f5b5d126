//! Twin of shaders/coarse_ties.wgsl: nodes of a level at a seam move as those on its other side.

use super::pyramid::{Pyramid, tie};
use crate::levels::ties::Ties;
use crate::number::real::Real;

/// Ties the nodes of a level, from 1 for the finest. `cut`: only those that are duplicates.
pub fn run<T: Real>(pyramids: &mut [Pyramid<T>], level: usize, cut: bool, ties: &[Ties]) {
    for tied in ties.get(level - 1).into_iter().flat_map(|t| t.of(cut)) {
        tie(pyramids, level - 1, tied);
    }
}
