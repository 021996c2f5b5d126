//! Twin of shaders/forget.wgsl: multipliers hold for one step.

use crate::number::real::Real;

/// Starts the `count` sums of a step at 0.
pub fn run<T: Real>(sums: &mut Vec<T>, count: usize) {
    sums.clear();
    sums.resize(count, T::of(0.0));
}
