//! Twin of shaders/separate.wgsl: particles go where contact pushes them.

use super::meeting::Meeting;
use super::meeting::tiles::{SIDE, rows};
use super::partners::TileList;
use crate::cpu::sheet::Sheet;
use crate::number::real::Real;

/// Moves the particles of tiles in which one is pushed, and their previous positions.
pub fn run<T: Real>(meeting: &Meeting<T>, sheets: &mut [Sheet<T>]) {
    for tile in meeting.active.iter().map(|tile| *tile as usize).filter(|tile| meeting.lists[*tile].moves) {
        let spot = meeting.tiles.spots[tile];
        let (sheet, list): (_, &TileList<T>) = (&mut sheets[spot.sheet as usize], &meeting.lists[tile]);
        let (half, row_len) = (sheet.half, sheet.row());
        for (n, row) in rows(sheet, spot).enumerate() {
            for c in 0..3 {
                let at = row * row_len + 2 * c * half + 2 * spot.column as usize;
                for (planes, change) in [(&mut sheet.now, &list.change[c]), (&mut sheet.before, &list.change[3 + c])] {
                    let change = &change[n * SIDE..(n + 1) * SIDE];
                    for m in 0..2 {
                        planes[at + m] = planes[at + m] + change[m];
                        planes[at + half + m] = planes[at + half + m] + change[2 + m];
                    }
                }
            }
        }
    }
}
