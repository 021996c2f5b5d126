//! Twin of shaders/inertia.wgsl: the motion of a frame of reference changes the velocities of free particles.

use crate::number::real::{Real, V3, add, scale, sub, with_w, xyz};

/// Changes previous positions; `numbers` are the columns of a matrix for displacements, those of one for positions, and a shift \[m\].
pub fn run<T: Real>(now: &[[T; 4]], before: &mut [[T; 4]], numbers: &[[T; 4]; 7]) {
    let of = |n: usize, v: V3<T>| {
        let column = |k: usize| scale(xyz(numbers[n + k]), v[k]);
        add(add(column(0), column(1)), column(2))
    };
    let shift = xyz(numbers[6]);
    for (p, b) in now.iter().zip(before).filter(|(p, _)| p[3] > T::of(0.0)) {
        let at = xyz(*p);
        let moved = add(add(of(0, sub(at, xyz(*b))), of(3, at)), shift);
        *b = with_w(sub(at, moved), b[3]);
    }
}
