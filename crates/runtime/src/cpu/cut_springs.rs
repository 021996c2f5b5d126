//! Twin of shaders/cut_springs.wgsl: springs of triangles that are cut away lose their rest lengths.

use super::neighbours::View;
use super::rows::Threads;
use crate::number::real::Real;

/// Sets to 0, which means no spring, the lengths of the springs of one grid that are an edge of a triangle that is cut
/// away, or that cross it in its quad.
pub fn run<T: Real>(threads: &Threads, view: View<T>, rest: &mut [[T; 4]]) {
    threads.chunks(rest, view.width, |j, row| {
        for (i, lengths) in row.iter_mut().enumerate() {
            let here = cut_away(view, Some(i), Some(j));
            let left = cut_away(view, i.checked_sub(1), Some(j));
            let above = cut_away(view, Some(i), j.checked_sub(1));
            let cut = [here & 2 | above & 1, here & 1 | left & 2, here, above];
            for (length, _) in lengths.iter_mut().zip(cut).filter(|(_, cut)| *cut != 0) {
                *length = T::of(0.0);
            }
        }
    });
}

/// What is cut away of a quad; the one triangle of a quad of three particles counts as both.
fn cut_away<T: Real>(view: View<T>, i: Option<usize>, j: Option<usize>) -> u32 {
    let (Some(i), Some(j)) = (i, j) else { return 0 };
    match (view.quad(i, j).0, view.removed(j * view.width + i)) {
        (0, _) => 0,
        (1, bits) if bits != 0 => 3,
        (_, bits) => bits,
    }
}
