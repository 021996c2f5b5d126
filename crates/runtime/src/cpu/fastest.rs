//! Twin of shaders/fastest.wgsl: the largest displacement of all.

use crate::number::real::Real;

/// The largest number of a list, at least 0.
pub fn run<T: Real>(partial: &[T]) -> T {
    partial.iter().fold(T::of(0.0), |far, p| larger(far, *p))
}

/// The larger number; NaN and infinity count as fast.
pub fn larger<T: Real>(a: T, b: T) -> T {
    let fast = T::of(3e38);
    let tame = |x: T| if x < fast { x } else { fast };
    tame(a).max(tame(b))
}
