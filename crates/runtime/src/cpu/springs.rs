//! Twin of shaders/springs.wgsl: one of the eight passes over springs that share no particle.

use super::rows::Threads;
use crate::number::real::{Real, add, dot, scale, sub, with_w, xyz};

/// Distance \[m\] below which the direction of a spring is not trusted to grow.
const CLOSEST: f64 = 1e-9;

/// One pass over one grid of `width` columns. `direction` counts right, down, down-right, up-right; springs of one
/// direction and one `parity` (of the column for "right", else of the upper row) have no particle in common. `length` is
/// the rest length of the spring stored at a texel.
pub fn run<T: Real>(
    threads: &Threads,
    now: &mut [[T; 4]],
    width: usize,
    (direction, parity): (u32, u32),
    length: impl Fn(usize) -> T + Sync + Send,
) {
    let parity = parity as usize;
    if direction == 0 {
        threads.chunks(now, width, |j, row| {
            for (pair, ends) in row[parity..].chunks_exact_mut(2).enumerate() {
                let (a, b) = ends.split_at_mut(1);
                relax(&mut a[0], &mut b[0], length(j * width + 2 * pair + parity));
            }
        });
        return;
    }
    threads.chunks(&mut now[parity * width..], 2 * width, |pair, rows| {
        if rows.len() < 2 * width {
            return;
        }
        let first = (2 * pair + parity) * width;
        let (upper, lower) = rows.split_at_mut(width);
        match direction {
            1 => each(upper, lower, |i| length(first + i)),
            2 => each(upper, &mut lower[1..], |i| length(first + i)),
            _ => each(lower, &mut upper[1..], |i| length(first + width + i)),
        }
    });
}

#[inline]
fn each<T: Real>(a: &mut [[T; 4]], b: &mut [[T; 4]], length: impl Fn(usize) -> T) {
    for (i, (a, b)) in a.iter_mut().zip(b).enumerate() {
        relax(a, b, length(i));
    }
}

/// Moves both ends along the spring to its rest length, in proportion to their inverse masses w: w1 / (w1 + w2) is the
/// responsiveness of the first. A length of 0 means no spring; w < 0 means no particle.
#[inline]
fn relax<T: Real>(a: &mut [T; 4], b: &mut [T; 4], length: T) {
    let sum = a[3] + b[3];
    if length <= T::of(0.0) || a[3].min(b[3]) < T::of(0.0) || sum <= T::of(0.0) {
        return;
    }
    let d = sub(xyz(*b), xyz(*a));
    let far = dot(d, d).sqrt().max(T::of(CLOSEST));
    let by = scale(d, T::of(1.0) - length / far);
    *a = with_w(add(xyz(*a), scale(by, a[3] / sum)), a[3]);
    *b = with_w(sub(xyz(*b), scale(by, b[3] / sum)), b[3]);
}
