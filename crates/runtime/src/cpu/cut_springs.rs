//! Twin of shaders/cut_springs.wgsl: springs of triangles that are cut away lose their rest lengths.

use super::neighbours::View;
use super::rows::Threads;
use crate::number::real::Real;

/// Sets to 0, which means no spring, the lengths of the springs of one grid that are an edge of a triangle that is cut
/// away, or that cross it in its quad.
pub fn run<T: Real>(threads: &Threads, view: View<T>, rest: &mut [[T; 4]]) {
    threads.chunks(rest, view.width, |j, row| {
        for (i, lengths) in row.iter_mut().enumerate() {
            let here = view.sides(Some(i), Some(j))[1];
            let left = view.sides(i.checked_sub(1), Some(j))[1];
            let above = view.sides(Some(i), j.checked_sub(1))[1];
            let cut = [here & 2 | above & 1, here & 1 | left & 2, here, above];
            for (length, _) in lengths.iter_mut().zip(cut).filter(|(_, cut)| *cut != 0) {
                *length = T::of(0.0);
            }
        }
    });
}
