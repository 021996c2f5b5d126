//! Twin of shaders/cut.wgsl: takes away the triangles that a cutting triangle meets.

use super::neighbours::View;
use super::rows::Threads;
use crate::number::real::{Real, V3, cross, dot, sub};

/// Sets the bits of the triangles of one grid that meet `cut`, in `holes`; `view` shows positions alone.
pub fn run<T: Real>(threads: &Threads, view: View<T>, cut: [V3<T>; 3], holes: &mut [u32]) {
    threads.chunks(holes, view.width, |j, row| {
        for (i, bits) in row.iter_mut().enumerate() {
            let (count, triangles) = view.quad(i, j);
            for (n, corners) in triangles.iter().enumerate().take(count as usize) {
                if *bits >> n & 1 == 0 {
                    *bits |= u32::from(meets(corners.map(|k| view.at(k)), cut)) << n;
                }
            }
        }
    });
}

/// Whether two triangles have a point in common, by separating axes; those of flat and of degenerate pairs are among
/// them. Closed, with a margin of 1e-6 of the distance between the farthest corners, which is above all rounding: no
/// triangle that is met is missed, whatever the order of its corners.
pub fn meets<T: Real>(p: [V3<T>; 3], q: [V3<T>; 3]) -> bool {
    let a = [sub(p[1], p[0]), sub(p[2], p[0])];
    let b = q.map(|x| sub(x, p[0]));
    let zero = T::of(0.0);
    let reach = a.iter().chain(&b).flatten().fold(zero, |far, x| far.max(x.abs()));
    let separates = |axis: V3<T>| {
        let (x, y) = (a.map(|v| dot(axis, v)), b.map(|v| dot(axis, v)));
        let margin = (axis[0].abs() + axis[1].abs() + axis[2].abs()) * (reach * T::of(1e-6));
        let low = zero.min(x[0]).min(x[1]) - y[0].max(y[1]).max(y[2]);
        let high = y[0].min(y[1]).min(y[2]) - zero.max(x[0]).max(x[1]);
        low.max(high) > margin
    };
    let one = T::of(1.0);
    if [[one, zero, zero], [zero, one, zero], [zero, zero, one]].into_iter().any(separates) {
        return false;
    }
    let e = [a[0], sub(a[1], a[0]), sub([zero; 3], a[1])];
    let f = [sub(b[1], b[0]), sub(b[2], b[1]), sub(b[0], b[2])];
    let (m, n) = (cross(e[0], e[1]), cross(f[0], f[1]));
    if separates(m) || separates(n) {
        return false;
    }
    !(0..3)
        .any(|k| separates(cross(m, e[k])) || separates(cross(n, f[k])) || (0..3).any(|l| separates(cross(e[k], f[l]))))
}

#[cfg(test)]
#[path = "cut_tests.rs"]
mod tests;
