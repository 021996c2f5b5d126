//! Twin of shaders/coarse_level.wgsl: lengths are limited on one coarser grid.

use super::pyramid::Pyramid;
use crate::cpu::rows::Threads;
use crate::number::real::Real;

/// Moves the nodes of a level, from 1 for the finest, with the one above, and limits their lengths. Nodes have been taken from the particles.
pub fn run<T: Real>(pyramids: &mut [Pyramid<T>], threads: &Threads, present: &[bool; 4], level: usize) {
    pyramids.iter_mut().for_each(|p| p.limit(threads, present, level - 1));
}
