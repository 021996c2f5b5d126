//! Cloth that was modelled into the body around its pins, such as the edge of a cape beneath a robe. It is pinned as well: free particles there would have
//! nowhere to go, as the surface of the body holds them off, and their springs draw them in.

use super::sheet::Sheet;
use super::wearer::Wearer;

/// A pin deeper \[m\] inside than this was modelled into the body: a runtime lets the cloth around it stay inside.
pub(crate) const TUCKED_M: f64 = 0.005;

/// Pins inside of the body, and points that were pinned beside them.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct Tuck {
    /// Texels that were pinned before.
    pub found: usize,
    /// Points that are pinned beside them.
    pub added: usize,
    /// Depth \[m\] of the deepest of all of them.
    pub deepest: f64,
}

/// Pins the points inside of the body that are connected through such points with a pin more than 5 mm inside of it. O(triangles of the body) per point.
pub(super) fn tuck(wearer: &Wearer, sheet: &Sheet, pinned: &mut [bool]) -> Tuck {
    let depths = wearer.depths(&sheet.positions);
    let mut open: Vec<u32> =
        (0..pinned.len() as u32).filter(|&p| pinned[p as usize] && depths[p as usize] > TUCKED_M).collect();
    let mut tuck = Tuck { found: open.len(), ..Tuck::default() };
    tuck.deepest = open.iter().map(|&p| depths[p as usize]).fold(0.0, f64::max);
    while let Some(p) = open.pop() {
        for q in sheet.neighbours(p) {
            if !pinned[q as usize] && depths[q as usize] > 0.0 {
                pinned[q as usize] = true;
                tuck.added += 1;
                tuck.deepest = tuck.deepest.max(depths[q as usize]);
                open.push(q);
            }
        }
    }
    tuck
}
