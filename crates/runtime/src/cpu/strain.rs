//! Twin of shaders/strain.wgsl: how far springs to the right and down are from their rest lengths.

use super::fastest::{self, larger};
use super::real::{Real, dot, sub, xyz};
use super::rows::Threads;

/// The largest square of length / rest length in one grid of `width` columns, 0 without springs; those between two pinned
/// particles do not count. `length` is the rest length of the spring of a direction that is stored at a texel. `partial` is
/// room for a number a row.
pub fn run<T: Real>(
    threads: &Threads,
    now: &[[T; 4]],
    width: usize,
    partial: &mut Vec<T>,
    length: impl Fn(usize, usize) -> T + Sync + Send,
) -> T {
    partial.resize(now.len() / width, T::of(0.0));
    threads.chunks(partial, 1, |j, out| {
        out[0] = (j * width..(j + 1) * width).fold(T::of(0.0), |most, k| {
            let right = if k + 1 < (j + 1) * width { ratio(&now[k], &now[k + 1], length(k, 0)) } else { T::of(0.0) };
            let down = if k + width < now.len() { ratio(&now[k], &now[k + width], length(k, 1)) } else { T::of(0.0) };
            larger(most, larger(right, down))
        });
    });
    fastest::run(partial)
}

#[inline]
fn ratio<T: Real>(a: &[T; 4], b: &[T; 4], rest: T) -> T {
    if rest <= T::of(0.0) || a[3].min(b[3]) < T::of(0.0) || a[3] + b[3] <= T::of(0.0) {
        return T::of(0.0);
    }
    let d = sub(xyz(*b), xyz(*a));
    dot(d, d) / (rest * rest)
}
