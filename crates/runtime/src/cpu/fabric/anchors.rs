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
}

impl<T: Real> Default for Places<T> {
    fn default() -> Self {
        Places { at: Vec::new(), planes: Vec::new() }
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
    /// Finds the anchors. A particle that is no longer pinned holds nothing: its place is NaN, and no distance to NaN is too large.
    pub fn find_anchors(&mut self) {
        let of = |m: &Member| {
            let sheet = &self.sheets[m.sheet as usize];
            let holds = sheet.w[m.single as usize] == T::of(0.0);
            if holds { sheet.at(m.at as usize) } else { [T::of(f64::NAN); 3] }
        };
        let at: Vec<V3<T>> = self.anchors.iter().map(of).collect();
        // By bits, so that NaN equals NaN.
        let (new, old) = (bytemuck::cast_slice::<_, u8>(&at), bytemuck::cast_slice::<_, u8>(&self.places.at));
        if self.places.planes.len() == self.tethers.len() && new == old {
            return;
        }
        self.places.planes.resize_with(self.tethers.len(), Vec::new);
        for ((sheet, tethers), planes) in self.sheets.iter().zip(&*self.tethers).zip(&mut self.places.planes) {
            planes.resize_with(tethers.slots.len(), Aligned::default);
            tethers.slots.iter().zip(planes).for_each(|(slot, planes)| arrange(sheet, slot, &at, planes));
        }
        self.places.at = at;
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
        for (b, anchors) in anchors.chunks_exact(LANES).enumerate().filter(|(b, _)| blocks[*b] == MIXED) {
            for (n, anchor) in anchors.iter().enumerate() {
                let p = at.get(*anchor as usize).copied().unwrap_or([T::of(0.0); 3]);
                (0..3).for_each(|c| row[c * wide + b * LANES + n] = p[c]);
            }
        }
    }
}
