//! Twin of shaders/separate.wgsl: particles go where contact pushes them.

use super::meeting::Meeting;
use super::meeting::tiles::{SIDE, rows};
use crate::cpu::sheet::Sheet;
use crate::number::real::Real;

/// Moves the particles of tiles in which one is pushed, and their previous positions.
pub fn run<T: Real>(meeting: &Meeting<T>, sheets: &mut [Sheet<T>]) {
    let moved = |tile: &u32| meeting.lists[*tile as usize].moves;
    let moved: Vec<u32> = meeting.active.iter().copied().filter(moved).collect();
    for run in meeting.tiles.runs(&moved) {
        let (spot, lists) = (meeting.tiles.spots[run.start], &meeting.lists[run]);
        let sheet = &mut sheets[spot.sheet as usize];
        let (half, row_len) = (sheet.half, sheet.row());
        for (n, row) in rows(sheet, spot).enumerate() {
            for c in 0..3 {
                let at = row * row_len + 2 * c * half + 2 * spot.column as usize;
                for (planes, c) in [(&mut sheet.now, c), (&mut sheet.before, 3 + c)] {
                    let (even, odd) = planes[at..at + half + 2 * lists.len()].split_at_mut(half);
                    let (even, odd) = (even.as_chunks_mut::<2>().0, odd.as_chunks_mut::<2>().0);
                    for (list, (even, odd)) in lists.iter().zip(even.iter_mut().zip(odd)) {
                        let change = &list.change[c].as_chunks::<SIDE>().0[n];
                        *even = [even[0] + change[0], even[1] + change[1]];
                        *odd = [odd[0] + change[2], odd[1] + change[3]];
                    }
                }
            }
        }
    }
}
