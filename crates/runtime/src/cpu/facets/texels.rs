//! Particles by texels, with gaps and holes.

use super::{Place, Row};
use crate::cpu::neighbours::View;
use crate::number::real::Real;

/// A grid by texels. Results of rows with gaps are those of `alone`, for the particle (i, j).
#[derive(Clone, Copy)]
pub struct Texels<'a, T, F> {
    pub view: View<'a, T>,
    /// Empty if no facet reads it.
    pub before: &'a [[T; 4]],
    pub alone: F,
}

impl<T: Real, F: Fn(usize, usize) -> [T; 4] + Copy + Send + Sync> Place<T> for Texels<'_, T, F> {
    type Item = [T; 4];

    fn size(&self) -> (usize, usize) {
        (self.view.width, self.view.now.len() / self.view.width)
    }

    fn row(&self) -> usize {
        self.view.width
    }

    fn fill(&self, j: usize, row: &mut Row<T>) -> bool {
        let View { now, width, holes } = self.view;
        let range = j * width..(j + 1) * width;
        let Row { now: [x, y, z], before: [a, b, c], w } = row;
        let now = &now[range.clone()];
        for ((((p, x), y), z), w) in now.iter().zip(x).zip(y).zip(z).zip(w) {
            [*x, *y, *z, *w] = *p;
        }
        for (((p, x), y), z) in self.before.get(range.clone()).unwrap_or(&[]).iter().zip(a).zip(b).zip(c) {
            [*x, *y, *z, _] = *p;
        }
        let there = now.iter().all(|p| p[3] >= T::of(0.0));
        there && holes.get(range).unwrap_or(&[]).iter().all(|h| *h == 0)
    }

    fn put(&self, [x, y, z, w]: &[Vec<T>; 4], to: &mut [[T; 4]]) {
        for (result, (((x, y), z), w)) in to.iter_mut().zip(x.iter().zip(y).zip(z).zip(w)) {
            *result = [*x, *y, *z, *w];
        }
    }

    fn mend(&self, j: usize, to: &mut [[T; 4]]) {
        to.iter_mut().enumerate().for_each(|(i, result)| *result = (self.alone)(i, j));
    }
}
