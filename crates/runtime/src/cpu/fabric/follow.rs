//! Twin of shaders/follow.wgsl: pinned particles that follow joints are where the skin is at the end of the step.

use crate::cpu::sheet::Sheet;
use crate::number::real::{Real, V3, scale, sub};

/// The particles of a sheet that follow joints while they are pinned.
pub struct Follow<T> {
    /// Where each lies in [`Sheet::w`] and in [`Sheet::now`].
    pub places: Vec<[u32; 2]>,
    /// Where it is at the end of the frame \[m\].
    pub to: Vec<V3<T>>,
    /// How fast it gets there \[m/s\].
    pub drift: Vec<V3<T>>,
}

/// Moves them on, with `left` \[s\] of the frame to go after the step.
pub fn run<T: Real>(sheet: &mut Sheet<T>, follow: &Follow<T>, left: T) {
    for (([single, triple], to), drift) in follow.places.iter().zip(&follow.to).zip(&follow.drift) {
        let at = *triple as usize;
        if sheet.w[*single as usize] != T::of(0.0) {
            continue;
        }
        let was = sheet.at(at);
        (0..3).for_each(|c| sheet.before[at + 2 * c * sheet.half] = was[c]);
        sheet.put(at, sub(*to, scale(*drift, left)));
    }
}
