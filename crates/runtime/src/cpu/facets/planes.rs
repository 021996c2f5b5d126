//! Particles in the planes of a sheet without gaps and holes.

use super::{Place, Row};
use crate::cpu::sheet::{Sheet, planes, planes_ref};
use crate::number::real::Real;

/// A whole sheet; results lie as [`Sheet::now`].
#[derive(Clone, Copy)]
pub struct Planes<'a, T: Real>(pub &'a Sheet<T>);

impl<T: Real> Place<T> for Planes<'_, T> {
    type Item = T;

    fn size(&self) -> (usize, usize) {
        (self.0.width, self.0.height)
    }

    fn row(&self) -> usize {
        self.0.row()
    }

    fn fill(&self, j: usize, row: &mut Row<T>) -> bool {
        let Sheet { half, now, before, w, .. } = self.0;
        for (from, to) in [(now, &mut row.now), (before, &mut row.before)] {
            let from = planes_ref(&from[j * 6 * half..(j + 1) * 6 * half], *half);
            from.iter().zip(to).for_each(|(from, to)| weave(from, *half, to));
        }
        weave(&w[j * 2 * half..(j + 1) * 2 * half], *half, &mut row.w);
        true
    }

    fn put(&self, from: &[Vec<T>; 4], to: &mut [T]) {
        let (half, width) = (self.0.half, self.0.width);
        for (from, to) in from.iter().zip(planes(to, half)) {
            let (even, odd) = to.split_at_mut(half);
            for (pair, (even, odd)) in from[..width].chunks(2).zip(even.iter_mut().zip(odd)) {
                *even = pair[0];
                *odd = pair.get(1).copied().unwrap_or(*odd);
            }
        }
    }
}

/// From `[even, odd]` to columns in their order.
fn weave<T: Real>(from: &[T], half: usize, to: &mut [T]) {
    let (even, odd) = from.split_at(half);
    for (pair, (even, odd)) in to.as_chunks_mut::<2>().0.iter_mut().zip(even.iter().zip(odd)) {
        *pair = [*even, *odd];
    }
}
