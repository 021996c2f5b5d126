//! Effects of a cut on rest lengths, bending, triangles of the membrane, coarser grids and stitches.

use std::sync::Arc;

use super::stretch::Rests;
use super::{Fabric, cut_levels};
use crate::cloth::other_end;
use crate::cpu::surface::Worn;
use crate::number::real::Real;

impl<T: Real> Fabric<T> {
    /// Rest lengths \[m\] by texels, after a cut; empty if there are no springs. Springs without a particle at an end are
    /// none.
    pub fn set_rest(&mut self, image: &[[T; 4]], now: &[[T; 4]]) {
        if image.is_empty() {
            return;
        }
        self.break_plates(image);
        self.worn.iter_mut().for_each(Worn::open);
        let there = |k: usize| now[k][3] >= T::of(0.0);
        for ((sheet, springs), first) in self.sheets.iter().zip(&mut self.springs).zip(&self.firsts) {
            for (d, of) in springs.iter_mut().enumerate() {
                let length = |k: usize| {
                    let other = other_end(sheet.width, sheet.height, k, d)?;
                    (there(first + k) && there(first + other)).then_some(image[first + k][d])
                };
                of.rest = Rests::List(Arc::new(sheet.list(T::of(0.0), |k| length(k).unwrap_or(T::of(0.0)))));
            }
        }
    }

    /// Rebuilds the coarser grids from rest lengths \[m\] by texels, after a cut.
    pub fn cut_levels(&mut self, image: &[[T; 4]]) {
        for ((pyramid, sheet), first) in self.pyramids.iter_mut().zip(&self.sheets).zip(&self.firsts) {
            let range = *first..first + sheet.width * sheet.height;
            if let Some(rest) = image.get(range.clone()) {
                let cut = cut_levels::run(sheet.width, rest, &self.masses[range]);
                *pyramid = cut.blind_as(pyramid);
            }
        }
    }

    /// Ends bending where springs are missing around a particle.
    fn break_plates(&mut self, image: &[[T; 4]]) {
        for ((sheet, plate), first) in self.sheets.iter().zip(&mut self.plates).zip(&self.firsts) {
            for k in 0..sheet.width * sheet.height {
                for (d, rest) in image[first + k].iter().enumerate() {
                    let broken = *rest <= T::of(0.0) && plate.weights.of(sheet.single(k), d) != T::of(0.0);
                    if let (true, Some(other)) = (broken, other_end(sheet.width, sheet.height, k, d)) {
                        let compliance = Arc::make_mut(&mut plate.compliance);
                        [k, other].iter().for_each(|k| compliance[sheet.single(*k)] = T::of(0.0));
                    }
                }
            }
        }
    }

    /// Triangles that are cut away leave the membrane; they are known by texels. Both of a cell that is divided otherwise. Stitches to a
    /// quad that lacks a triangle end.
    pub fn cut_cells(&mut self, holes: &[u32]) {
        if let Some(stitches) = &mut self.stitches {
            let each = stitches.holds.iter_mut().zip(&*stitches.threads);
            each.for_each(|(holds, thread)| *holds = holes[thread.cell as usize] == 0);
        }
        for ((sheet, cells), first) in self.sheets.iter().zip(Arc::make_mut(&mut self.cells)).zip(&self.firsts) {
            for k in (0..sheet.width * sheet.height).filter(|k| holes[first + k] != 0) {
                let place = sheet.single(k);
                let [p, q, r, s, e, f, g, h] = cells.inverse.each_ref().map(|list| list[place]);
                let up = p * s - q * r + e * h - f * g < T::of(0.0);
                for (triangle, bit) in [(0, 2), (4, 1)] {
                    if up || holes[first + k] & bit != 0 {
                        cells.inverse[triangle..triangle + 4].iter_mut().for_each(|list| list[place] = T::of(0.0));
                    }
                }
            }
        }
    }
}
