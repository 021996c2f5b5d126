//! Positions, inverse masses and rest lengths of a cloth between texels and sheets.

use super::Fabric;
use super::meeting::Meeting;
use crate::number::real::Real;

impl<T: Real> Fabric<T> {
    /// Positions and inverse masses from texels.
    pub fn load(&mut self, now: &[[T; 4]], before: &[[T; 4]]) {
        self.meeting.iter_mut().for_each(Meeting::search_again);
        for (sheet, first) in self.sheets.iter_mut().zip(&self.firsts) {
            let range = *first..first + sheet.width * sheet.height;
            sheet.load(&now[range.clone()], &before[range]);
            // A NaN in a texel without a particle would stay NaN when multiplied by a weight of 0.
            let gaps = (0..sheet.width * sheet.height).filter(|k| now[first + k][3] < T::of(0.0));
            if !self.plates.is_empty() {
                gaps.for_each(|k| sheet.put(sheet.triple(k), [T::of(0.0); 3]));
            }
            sheet.weigh(|k| now[first + k][3]);
        }
    }

    /// Positions to texels.
    pub fn store(&self, now: &mut [[T; 4]], before: &mut [[T; 4]]) {
        for (sheet, first) in self.sheets.iter().zip(&self.firsts) {
            let range = *first..first + sheet.width * sheet.height;
            sheet.store(&mut now[range.clone()], &mut before[range]);
        }
    }

    /// The low bits that positions are too coarse for, to texels; where none are kept these stay.
    pub fn store_lost(&self, texels: &mut [[T; 4]]) {
        for (sheet, first) in self.sheets.iter().zip(&self.firsts) {
            sheet.store_lost(&mut texels[*first..first + sheet.width * sheet.height]);
        }
    }

    /// The same from texels; to be called after [`Fabric::load`].
    pub fn load_lost(&mut self, texels: &[[T; 4]]) {
        for (sheet, first) in self.sheets.iter_mut().zip(&self.firsts) {
            sheet.load_lost(&texels[*first..*first + sheet.width * sheet.height]);
        }
    }
}
