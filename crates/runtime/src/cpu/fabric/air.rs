//! Wind on the sheets of a cloth.

use super::Fabric;
use crate::cpu::body::Body;
use crate::cpu::neighbours::View;
use crate::cpu::rows::Threads;
use crate::cpu::sheet::Sheet;
use crate::cpu::{gust, wind};
use crate::number::aligned::Aligned;
use crate::number::real::Real;
use crate::step::Step;

impl<T: Real> Fabric<T> {
    /// Velocities of the air at the particles of all sheets.
    pub(super) fn gust(&mut self, threads: &Threads, step: &Step<T>) {
        let each = self.sheets.iter().zip(room(&self.sheets, &mut self.airs));
        each.for_each(|(sheet, airs)| gust::of_sheet(threads, step, sheet, airs));
    }

    /// Accelerations by air, of texels where a sheet has gaps, and of its rows elsewhere.
    pub(super) fn wind(&mut self, threads: &Threads, step: &Step<T>, body: &mut Body<T>, (gusts, holes): (bool, bool)) {
        let apart = holes || self.whole.contains(&false);
        if apart {
            self.field.resize(body.now.len(), [T::of(0.0); 4]);
            self.store(&mut body.now, &mut body.before);
        }
        let count = if apart && gusts { body.now.len() } else { 0 };
        self.airs_of_texels.resize(count, [T::of(0.0); 4]);
        let direct = self.whole.iter().map(|whole| *whole && !holes);
        let (now, before, holes) = (&body.now, &body.before, &body.holes);
        let fields = room(&self.sheets, &mut self.fields);
        let each = self.sheets.iter().zip(&self.firsts).zip(fields).zip(direct).enumerate();
        for (g, (((sheet, first), field), direct)) in each {
            let airs = if gusts { &self.airs[g][..] } else { &[] };
            if direct {
                wind::of_sheet(threads, step, sheet, airs, field);
                continue;
            }
            let range = *first..first + sheet.width * sheet.height;
            let mut of_texels = &mut self.airs_of_texels[..];
            if gusts {
                of_texels = &mut of_texels[range.clone()];
                sheet.gather(airs, of_texels);
            }
            let holes = holes.get(range.clone()).unwrap_or(&[]);
            let view = View { now: &now[range.clone()], width: sheet.width, holes };
            wind::run(threads, step, view, [&before[range.clone()], of_texels], &mut self.field[range.clone()]);
            sheet.arrange(&self.field[range], field);
        }
    }
}

/// A list for each sheet, as its positions lie.
fn room<'a, T: Real>(sheets: &[Sheet<T>], lists: &'a mut Vec<Aligned<T>>) -> impl Iterator<Item = &'a mut Aligned<T>> {
    lists.resize_with(sheets.len(), Aligned::default);
    for (sheet, list) in sheets.iter().zip(&mut *lists) {
        if list.len() != sheet.now.len() {
            *list = Aligned::zeros(sheet.now.len());
        }
    }
    lists.iter_mut()
}
