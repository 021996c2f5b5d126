//! Where the anchors of tethers are: by anchor, and by particle where neighbours have several.

use super::Fabric;
use super::seam_steps::Member;
use super::tethers::{MIXED, Slot};
use crate::cpu::sheet::Sheet;
use crate::number::aligned::Aligned;
use crate::number::lanes::LANES;
use crate::number::real::{Real, V3};

/// The anchors of a cloth, kept from pass to pass: most passes find them where they were in the pass before.
pub struct Places<T: Real> {
    /// Where each is \[m\].
    at: Vec<V3<T>>,
    /// For every sheet and slot where the anchor of each particle is, in the layout of [`Sheet::now`], in blocks with several anchors; empty
    /// for a slot with one anchor.
    pub planes: Vec<Vec<Aligned<T>>>,
    /// Whether the anchors were found in this step. Pinned particles move between steps, and in the first pass of a step, which is before all
    /// tethers.
    pub found: bool,
}

impl<T: Real> Default for Places<T> {
    fn default() -> Self {
        Places { at: Vec::new(), planes: Vec::new(), found: false }
    }
}

/// The anchors of a sheet.
#[derive(Clone, Copy)]
pub struct Anchors<'a, T: Real> {
    /// As [`Places::at`].
    pub at: &'a [V3<T>],
    /// One per slot.
    pub planes: &'a [Aligned<T>],
}

impl<T: Real> Places<T> {
    /// Those of a sheet.
    pub fn of(&self, sheet: usize) -> Anchors<'_, T> {
        Anchors { at: &self.at, planes: self.planes.get(sheet).map_or(&[], |planes| planes) }
    }
}

impl<T: Real> Fabric<T> {
    /// Finds the positions of the anchors, once per step. A particle that is no longer pinned holds no other one: its position counts as NaN, and
    /// no distance is larger than NaN.
    pub fn find_anchors(&mut self) {
        if std::mem::replace(&mut self.places.found, true) {
            return;
        }
        let mut moved = self.places.planes.len() != self.tethers.len();
        self.places.at.resize(self.anchors.len(), [T::of(0.0); 3]);
        for (m, at) in self.anchors.iter().zip(&mut self.places.at) {
            let Member { sheet, at: place, single } = *m;
            let sheet = &self.sheets[sheet as usize];
            let holds = sheet.w[single as usize] == T::of(0.0);
            let new = if holds { sheet.at(place as usize) } else { [T::of(f64::NAN); 3] };
            // By bits, so that NaN equals NaN.
            moved |= bytemuck::bytes_of(&new) != bytemuck::bytes_of(at);
            *at = new;
        }
        if moved {
            self.arrange_anchors();
        }
    }

    /// Writes where the anchors of particles are whose neighbours have others.
    fn arrange_anchors(&mut self) {
        let Places { at, planes, .. } = &mut self.places;
        planes.resize_with(self.tethers.len(), Vec::new);
        for ((sheet, tethers), planes) in self.sheets.iter().zip(&*self.tethers).zip(planes) {
            planes.resize_with(tethers.slots.len(), Aligned::default);
            tethers.slots.iter().zip(planes).for_each(|(slot, planes)| arrange(sheet, slot, at, planes));
        }
    }
}

/// Writes where the anchors of particles of a slot are.
pub fn arrange<T: Real>(sheet: &Sheet<T>, slot: &Slot<T>, at: &[V3<T>], planes: &mut Aligned<T>) {
    if slot.one != MIXED {
        return;
    }
    if planes.len() != sheet.now.len() {
        *planes = Aligned::zeros(sheet.now.len());
    }
    let wide = 2 * sheet.half;
    let rows = planes.chunks_exact_mut(3 * wide).zip(slot.anchor.chunks_exact(wide));
    for ((row, anchors), blocks) in rows.zip(slot.block.chunks_exact(wide / LANES)) {
        let [x, y, z] = crate::cpu::sheet::planes(row, sheet.half).map(|plane| plane.as_chunks_mut::<LANES>().0);
        let blocks = blocks.iter().zip(anchors.as_chunks::<LANES>().0);
        for (((x, y), z), (_, anchors)) in x.iter_mut().zip(y).zip(z).zip(blocks).filter(|(_, (one, _))| **one == MIXED)
        {
            for (n, anchor) in anchors.iter().enumerate() {
                // Particles without an anchor have none within reach: any place does.
                [x[n], y[n], z[n]] = at.get(*anchor as usize).copied().unwrap_or([T::of(0.0); 3]);
            }
        }
    }
}
