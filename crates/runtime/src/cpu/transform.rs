//! Twin of shaders/transform.wgsl: moves chosen particles by a matrix.

use crate::number::real::{Real, add, scale, with_w};

/// Moves particles, and their previous positions alike, by the matrix with these columns. Not shared out: a set is
/// chosen by hand.
pub fn run<T: Real>(now: &mut [[T; 4]], before: &mut [[T; 4]], chosen: &[u32], matrix: [[T; 4]; 4]) {
    let [x, y, z, t] = matrix.map(|c| [c[0], c[1], c[2]]);
    let moved = |p: [T; 4]| with_w(add(add(add(scale(x, p[0]), scale(y, p[1])), scale(z, p[2])), t), p[3]);
    for &k in chosen {
        let k = k as usize;
        (now[k], before[k]) = (moved(now[k]), moved(before[k]));
    }
}
