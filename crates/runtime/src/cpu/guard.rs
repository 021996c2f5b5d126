//! Twin of shaders/guard.wgsl: particles whose position is NaN or out of bounds.

use crate::number::real::Real;

/// Coordinates \[m\] beyond this are taken for a fault: squares of distances must stay numbers.
pub const FARTHEST: f64 = 1e8;

/// Whether a position is a number and within all bounds.
pub fn is_sane<T: Real>(p: [T; 3]) -> bool {
    // Comparisons with NaN are false.
    p.iter().all(|x| x.abs() <= T::of(FARTHEST))
}

/// How many there are, and the last of them.
pub fn run<T: Real>(now: &[[T; 4]]) -> Option<(usize, usize)> {
    let most = T::of(FARTHEST);
    // Comparisons with NaN are false.
    // Nearly always none is at fault, which is quicker to see without a branch for each.
    let fault =
        |p: &[T; 4]| (p[3] >= T::of(0.0)) & !((p[0].abs() <= most) & (p[1].abs() <= most) & (p[2].abs() <= most));
    if !now.chunks(64).any(|some| some.iter().fold(false, |any, p| any | fault(p))) {
        return None;
    }
    let mut faults = now.iter().enumerate().filter(|(_, p)| fault(p)).map(|(k, _)| k);
    faults.next().map(|first| faults.fold((1, first), |(count, _), k| (count + 1, k)))
}
