//! Particles in the planes of a sheet without gaps and holes.

use super::{Place, Row};
use crate::cpu::sheet::{Sheet, planes, planes_ref};
use crate::number::real::Real;

/// A whole sheet, and velocities of the air at its particles as [`Sheet::now`], or none; results lie so too.
#[derive(Clone, Copy)]
pub struct Planes<'a, T: Real> {
    pub sheet: &'a Sheet<T>,
    pub airs: &'a [T],
}

impl<T: Real> Place<T> for Planes<'_, T> {
    type Item = T;

    fn size(&self) -> (usize, usize) {
        (self.sheet.width, self.sheet.height)
    }

    fn row(&self) -> usize {
        self.sheet.row()
    }

    fn airs(&self) -> bool {
        !self.airs.is_empty()
    }

    fn fill(&self, j: usize, row: &mut Row<T>) -> bool {
        let Sheet { half, now, before, w, .. } = self.sheet;
        let range = j * 6 * half..(j + 1) * 6 * half;
        for (from, to) in [(&now[..], &mut row.now), (before, &mut row.before), (self.airs, &mut row.air)] {
            let Some(from) = from.get(range.clone()) else { continue };
            let from = planes_ref(from, *half);
            from.iter().zip(to).for_each(|(from, to)| to.copy_from_slice(from));
        }
        row.w.copy_from_slice(&w[j * 2 * half..(j + 1) * 2 * half]);
        true
    }

    fn put(&self, from: &[Vec<T>; 4], to: &mut [T]) {
        let to = planes(to, self.sheet.half);
        from.iter().zip(to).for_each(|(from, to)| to.copy_from_slice(from));
    }
}
