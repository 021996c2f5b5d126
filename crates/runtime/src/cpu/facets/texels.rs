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

    // Inlined, as `put`, into code for the machine's vectors.
    #[inline(always)]
    fn fill(&self, j: usize, row: &mut Row<T>) -> bool {
        let View { now, width, holes } = self.view;
        let range = j * width..(j + 1) * width;
        let now = &now[range.clone()];
        let half = half_row(width);
        let Row { now: [x, y, z], before, air, w } = &mut *row;
        part(now, half, [x, y, z, w]);
        for (from, [x, y, z]) in [(self.before, before), (self.airs, air)] {
            if let Some(from) = from.get(range.clone()) {
                part(from, half, [x, y, z]);
            }
        }
        // Without an early end it is a loop of vectors; past the end of a row are zeros.
        let there = row.w.iter().fold(true, |there, w| there & (*w >= T::of(0.0)));
        there && holes.get(range).unwrap_or(&[]).iter().all(|h| *h == 0)
    }

    #[inline(always)]
    fn put(&self, from: &[Vec<T>; 4], to: &mut [[T; 4]]) {
        let (half, count) = (half_row(self.view.width), self.view.width / 2);
        let [x, y, z, w] = from.each_ref().map(|list| list.split_at(half));
        let even = x.0[..count].iter().zip(&y.0[..count]).zip(&z.0[..count]).zip(&w.0[..count]);
        let odd = x.1[..count].iter().zip(&y.1[..count]).zip(&z.1[..count]).zip(&w.1[..count]);
        let (pairs, last) = to.as_chunks_mut::<2>();
        for (pair, ((((x, y), z), w), (((a, b), c), d))) in pairs.iter_mut().zip(even.zip(odd)) {
            *pair = [[*x, *y, *z, *w], [*a, *b, *c, *d]];
        }
        for last in last {
            *last = [x.0[count], y.0[count], z.0[count], w.0[count]];
        }
    }

    fn mend(&self, j: usize, to: &mut [[T; 4]]) {
        to.iter_mut().enumerate().for_each(|(i, result)| *result = (self.alone)(i, j));
    }
}

/// Copies the first numbers of a row of texels into lists of `[even, odd]`, one a number.
#[inline(always)]
fn part<T: Real, const N: usize>(from: &[[T; 4]], half: usize, to: [&mut Vec<T>; N]) {
    let (pairs, last) = from.as_chunks::<2>();
    // A list after the other, which takes 0.6 of the time of all in one loop: two lists at a time become shuffles of vectors.
    for (c, to) in to.into_iter().enumerate() {
        let (even, odd) = to.split_at_mut(half);
        for last in last {
            even[pairs.len()] = last[c];
        }
        for ((pair, even), odd) in pairs.iter().zip(even).zip(odd) {
            (*even, *odd) = (pair[0][c], pair[1][c]);
        }
    }
}
