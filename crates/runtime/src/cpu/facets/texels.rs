//! Particles by texels, with gaps and holes.

use super::{Place, Row};
use crate::cpu::neighbours::View;
use crate::cpu::sheet::half_row;
use crate::number::real::Real;

/// A grid by texels. Results of rows with gaps are those of `alone`, for the particle (i, j).
#[derive(Clone, Copy)]
pub struct Texels<'a, T, F> {
    pub view: View<'a, T>,
    /// Previous positions, and velocities of the air; empty where no corner asks for them.
    pub before: &'a [[T; 4]],
    pub airs: &'a [[T; 4]],
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

    fn airs(&self) -> bool {
        !self.airs.is_empty()
    }

    fn fill(&self, j: usize, row: &mut Row<T>) -> bool {
        let View { now, width, holes } = self.view;
        let range = j * width..(j + 1) * width;
        let now = &now[range.clone()];
        let Row { now: [x, y, z], before, air, w } = row;
        part(now, [x, y, z, w]);
        for (from, [x, y, z]) in [(self.before, before), (self.airs, air)] {
            let mut none = Vec::new();
            part(from.get(range.clone()).unwrap_or(&[]), [x, y, z, &mut none]);
        }
        let there = now.iter().all(|p| p[3] >= T::of(0.0));
        there && holes.get(range).unwrap_or(&[]).iter().all(|h| *h == 0)
    }

    fn put(&self, from: &[Vec<T>; 4], to: &mut [[T; 4]]) {
        let half = half_row(self.view.width);
        let [x, y, z, w] = from.each_ref().map(|list| list.split_at(half));
        let even = x.0.iter().zip(y.0).zip(z.0).zip(w.0);
        let odd = x.1.iter().zip(y.1).zip(z.1).zip(w.1);
        for (pair, ((((x, y), z), w), (((a, b), c), d))) in to.chunks_mut(2).zip(even.zip(odd)) {
            pair[0] = [*x, *y, *z, *w];
            if let Some(second) = pair.get_mut(1) {
                *second = [*a, *b, *c, *d];
            }
        }
    }

    fn mend(&self, j: usize, to: &mut [[T; 4]]) {
        to.iter_mut().enumerate().for_each(|(i, result)| *result = (self.alone)(i, j));
    }
}

/// Copies a row of texels into lists of `[even, odd]`; an empty list is left out.
fn part<T: Real>(from: &[[T; 4]], to: [&mut Vec<T>; 4]) {
    for (c, to) in to.into_iter().enumerate() {
        let half = to.len() / 2;
        let (even, odd) = to.split_at_mut(half);
        for (pair, (even, odd)) in from.chunks(2).zip(even.iter_mut().zip(odd)) {
            *even = pair[0][c];
            if let Some(second) = pair.get(1) {
                *odd = second[c];
            }
        }
    }
}
