//! Twin of shaders/speed.wgsl: how far free particles have moved in the last step.

use super::fastest::larger;
use super::rows::Threads;
use crate::number::real::{Real, dot, sub, xyz};

const GROUP: usize = 64;

/// Writes the largest squared displacement \[m^2\] of each 64 particles.
pub fn run<T: Real>(threads: &Threads, now: &[[T; 4]], before: &[[T; 4]], partial: &mut Vec<T>) {
    partial.resize(now.len().div_ceil(GROUP), T::of(0.0));
    threads.chunks(partial, 1, |group, out| {
        let range = group * GROUP..now.len().min((group + 1) * GROUP);
        out[0] = range.filter(|k| now[*k][3] > T::of(0.0)).fold(T::of(0.0), |far, k| {
            let d = sub(xyz(now[k]), xyz(before[k]));
            larger(far, dot(d, d))
        });
    });
}
