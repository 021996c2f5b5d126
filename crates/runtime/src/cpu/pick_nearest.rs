//! Twin of shaders/pick_nearest.wgsl: the nearest of all candidates.

use super::pick::{Candidate, nearer};
use crate::number::real::Real;

/// The nearest one, if there is any.
pub fn run<T: Real>(candidates: impl IntoIterator<Item = Candidate<T>>) -> Option<Candidate<T>> {
    candidates.into_iter().reduce(nearer)
}
