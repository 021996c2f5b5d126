//! Twin of shaders/seam_steps.wgsl: all duplicates of a seam point take one position, and one previous position.
//!
//! Coarser grids move both. With previous positions left apart, duplicates would fly apart by the next step, the farther
//! the more they had been drawn together: cloth would gain energy at its seams.

use crate::cpu::sheet::Sheet;
use crate::number::aligned::Aligned;
use crate::number::real::{Real, add, scale};

/// A member of a ring: its sheet, where its x lies in [`Sheet::now`], and where its inverse mass lies in [`Sheet::w`].
#[derive(Clone, Copy, Debug, Default)]
pub struct Member {
    pub sheet: u32,
    pub at: u32,
    pub single: u32,
}

/// Rings as offsets into a list of members.
pub fn run<T: Real>(sheets: &mut [Sheet<T>], starts: &[u32], members: &[Member]) {
    for ring in starts.windows(2).map(|r| &members[r[0] as usize..r[1] as usize]) {
        close(sheets, ring, |s| &mut s.now);
        close(sheets, ring, |s| &mut s.before);
    }
}

/// The rule of seams.rs for one ring, on positions or on previous ones.
#[inline]
pub fn close<T: Real>(sheets: &mut [Sheet<T>], ring: &[Member], of: impl Fn(&mut Sheet<T>) -> &mut Aligned<T>) {
    let mut sum = [T::of(0.0); 3];
    let mut pinned = None;
    for member in ring {
        let (sheet, at) = (&mut sheets[member.sheet as usize], member.at as usize);
        let (half, holds) = (sheet.half, sheet.w[member.single as usize] == T::of(0.0));
        let list = of(sheet);
        let p = [list[at], list[at + 2 * half], list[at + 4 * half]];
        if holds {
            pinned = Some(p);
            break;
        }
        sum = add(sum, p);
    }
    // Nearly every ring is a pair, and a division would be its largest cost.
    let share = if ring.len() == 2 { T::of(0.5) } else { T::of(1.0) / T::of(ring.len() as f64) };
    let mean = pinned.unwrap_or(scale(sum, share));
    for member in ring {
        let (sheet, at) = (&mut sheets[member.sheet as usize], member.at as usize);
        let half = sheet.half;
        let list = of(sheet);
        (0..3).for_each(|c| list[at + 2 * c * half] = mean[c]);
    }
}
