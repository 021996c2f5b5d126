//! Wind on the sheets of a cloth.

use super::Fabric;
use crate::cpu::body::Body;
use crate::cpu::neighbours::View;
use crate::cpu::rows::Threads;
use crate::cpu::wind;
use crate::number::aligned::Aligned;
use crate::number::real::Real;
use crate::step::Step;

impl<T: Real> Fabric<T> {
    /// Accelerations by air, of texels where a sheet has gaps, and of its rows elsewhere.
    pub(super) fn wind(&mut self, threads: &Threads, step: &Step<T>, body: &mut Body<T>, holes: bool) {
        self.fields.resize_with(self.sheets.len(), Aligned::default);
        for (sheet, field) in self.sheets.iter().zip(&mut self.fields) {
            if field.len() != sheet.now.len() {
                *field = Aligned::zeros(sheet.now.len());
            }
        }
        if holes || self.whole.contains(&false) {
            self.field.resize(body.now.len(), [T::of(0.0); 4]);
            self.store(&mut body.now, &mut body.before);
        }
        let direct = self.whole.iter().map(|whole| *whole && !holes);
        let (now, before, holes) = (&body.now, &body.before, &body.holes);
        let each = self.sheets.iter().zip(&self.firsts).zip(&mut self.fields).zip(direct);
        for (((sheet, first), field), direct) in each {
            if direct {
                wind::of_sheet(threads, step, sheet, field);
                continue;
            }
            let range = *first..first + sheet.width * sheet.height;
            let holes = holes.get(range.clone()).unwrap_or(&[]);
            let view = View { now: &now[range.clone()], width: sheet.width, holes };
            wind::run(threads, step, view, &before[range.clone()], &mut self.field[range.clone()]);
            sheet.arrange(&self.field[range], field);
        }
    }
}
