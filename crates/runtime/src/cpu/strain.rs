//! Twin of shaders/strain.wgsl: how far springs to the right and down are from where relaxation would bring them.

use super::fastest::{self, larger};
use super::rows::Threads;
use crate::number::real::{Real, dot, sub, xyz};

/// The springs of one grid.
pub struct Springs<'a, T, L, G> {
    /// Positions.
    pub now: &'a [[T; 4]],
    /// Columns.
    pub width: usize,
    /// Rest length of the spring of a direction that is stored at a texel.
    pub length: L,
    /// Its compliance.
    pub gives: G,
    /// Length of the last step.
    pub dt: T,
}

/// The largest residual, 0 without springs. `partial` is room for a number a row.
pub fn run<T, L, G>(threads: &Threads, springs: &Springs<T, L, G>, partial: &mut Vec<T>) -> T
where
    T: Real,
    L: Fn(usize, usize) -> T + Sync + Send,
    G: Fn(usize, usize) -> T + Sync + Send,
{
    let Springs { now, width, .. } = *springs;
    partial.resize(now.len() / width, T::of(0.0));
    threads.chunks(partial, 1, |j, out| {
        out[0] = (j * width..(j + 1) * width).fold(T::of(0.0), |most, k| {
            let right = if k + 1 < (j + 1) * width { residual(springs, k, k + 1, 0) } else { T::of(0.0) };
            let down = if k + width < now.len() { residual(springs, k, k + width, 1) } else { T::of(0.0) };
            larger(most, larger(right, down))
        });
    });
    fastest::run(partial)
}

/// Stretch, less what compliance accounts for: at rest a relaxation takes the share `s / (s + compliance)` of a stretch
/// away, `s = w dt^2`, and the next step brings it back; the rest is what the spring yields.
#[inline]
fn residual<T: Real, L, G>(springs: &Springs<T, L, G>, k: usize, other: usize, direction: usize) -> T
where
    L: Fn(usize, usize) -> T,
    G: Fn(usize, usize) -> T,
{
    let (a, b, rest) = (springs.now[k], springs.now[other], (springs.length)(k, direction));
    let w = a[3] + b[3];
    if rest <= T::of(0.0) || a[3].min(b[3]) < T::of(0.0) || w <= T::of(0.0) {
        return T::of(0.0);
    }
    let d = sub(xyz(b), xyz(a));
    let stretch = (dot(d, d).sqrt() / rest - T::of(1.0)).max(T::of(0.0));
    let (gives, moves) = ((springs.gives)(k, direction), w * springs.dt * springs.dt);
    if gives <= T::of(0.0) { stretch } else { stretch * (moves / (gives + moves)) }
}
