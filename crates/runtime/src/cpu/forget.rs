//! Twin of shaders/forget.wgsl: multipliers hold for one step.

use super::real::Real;

/// Starts the sums of a step at 0.
pub fn run<T: Real>(sums: &mut [T]) {
    sums.fill(T::of(0.0));
}
