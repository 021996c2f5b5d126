//! How far cloth that is caught at a body may go into it, as `give` in shaders/surface_search.wgsl.
//!
//! A pose can bring a part of a body, such as an arm that comes down, between two parts of a cloth, or hook it. Contact would hold both apart and stretch the
//! cloth between them without end. So it gives way where cloth is much too long, until the cloth pulls itself free. One spring can be that long
//! beside a pin, or in a crease, and more so in fast motion; several in a row are not. Where a thin part of a body, such as the rim of a hood, comes to be among particles, half of them leave
//! it by either side, and single springs are several times their length.

use super::length;
use super::search::beside;
use crate::choose::stiff;
use crate::cloth::{Cloth, Rest};
use crate::cpu::sheet::Sheet;
use crate::number::real::{Real, sub};

/// Cells between the particles that are compared.
pub const SPAN: usize = 4;
/// Contact gives way where they are farther from each other than this many times the length at rest.
pub const CAUGHT: f64 = 1.3;
/// And where neighbours are farther from each other than this share of that length, three times their spring at rest: half of them on one side of a thin part of the body, half on the other.
pub const CAUGHT_BESIDE: f64 = 0.75;
/// Depth \[m\] for each metre above that: with cells of 1 cm nothing holds a particle between others at some 1.45 times the length at rest.
pub const CAUGHT_GIVE: f64 = 8.0;

/// Whether contact ever gives way: the stretch of cloth is an error. After a cut, neighbours may be anywhere.
pub fn gives(cloth: &Cloth) -> bool {
    stiff(cloth) && !cloth.is_cut()
}

/// For each particle the lengths \[m\] of cloth at rest up to the four that are [`SPAN`] cells [`beside`] it; 0 where a spring is missing on the way.
pub fn spans(cloth: &Cloth) -> Vec<[f32; 4]> {
    let mut spans = vec![[0.0; 4]; cloth.len()];
    for (g, grid) in cloth.grids().iter().enumerate() {
        let (first, size) = (grid.first as usize, (grid.width as usize, grid.height as usize));
        let exists = |k: usize| cloth.particles()[first + k].exists();
        let spring = |k: usize, down: usize| match cloth.rest() {
            Rest::None => 0.0,
            Rest::Constant(lengths) => lengths[g][down],
            Rest::Image(lengths) => lengths[first + k][down],
        };
        for (k, side) in (0..size.0 * size.1).flat_map(|k| (0..4u32).map(move |side| (k, side))) {
            let Some(n) = beside(k, size, SPAN, side) else { continue };
            let (down, step) = [(0, 1), (1, size.0)][side as usize & 1];
            let way = || (0..SPAN).map(|m| k.min(n) + m * step);
            let is_whole = exists(k.max(n)) && way().all(|k| exists(k) && spring(k, down) > 0.0);
            spans[first + k][side as usize] = if is_whole { way().map(|k| spring(k, down)).sum() } else { 0.0 };
        }
    }
    spans
}

/// How much deeper \[m\] than else particle `k` of a sheet may be.
#[inline]
pub(super) fn give<T: Real>(sheet: &Sheet<T>, k: usize, spans: &[f32; 4]) -> T {
    let p = sheet.at(sheet.triple(k));
    let mut most = T::of(0.0);
    for (side, span) in spans.iter().enumerate().filter(|(_, span)| **span > 0.0) {
        for (cells, share) in [(SPAN, CAUGHT), (1, CAUGHT_BESIDE)] {
            if let Some(n) = beside(k, (sheet.width, sheet.height), cells, side as u32) {
                let far = length(sub(sheet.at(sheet.triple(n)), p));
                most = most.max(far - T::of(share) * T::of(f64::from(*span)));
            }
        }
    }
    most * T::of(CAUGHT_GIVE)
}
