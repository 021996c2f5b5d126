//! Twin of shaders/seam_steps.wgsl: all duplicates of a seam point take one position, and one previous position.
//!
//! Coarser grids move both. With previous positions left apart, duplicates would fly apart by the next step, the farther
//! the more they had been drawn together: cloth would gain energy at its seams.

use super::fabric::single;
use super::sheet::Sheet;
use crate::number::aligned::Aligned;
use crate::number::real::{Real, add, scale};

/// Rings as offsets into a list of sheets and places in them.
pub fn run<T: Real>(sheets: &mut [Sheet<T>], starts: &[u32], members: &[(u32, u32)]) {
    for ring in starts.windows(2).map(|r| &members[r[0] as usize..r[1] as usize]) {
        close(sheets, ring, |s| &mut s.now);
        close(sheets, ring, |s| &mut s.before);
    }
}

/// The rule of seams.rs for one ring, on positions or on previous ones.
pub fn close<T: Real>(sheets: &mut [Sheet<T>], ring: &[(u32, u32)], of: impl Fn(&mut Sheet<T>) -> &mut Aligned<T>) {
    let mut sum = [T::of(0.0); 3];
    let mut pinned = None;
    for (g, at) in ring {
        let (sheet, at) = (&mut sheets[*g as usize], *at as usize);
        let (half, list) = (sheet.half, of(sheet));
        let p = [list[at], list[at + 2 * half], list[at + 4 * half]];
        if sheet.w[single(at, half)] == T::of(0.0) {
            pinned = Some(p);
            break;
        }
        sum = add(sum, p);
    }
    let mean = pinned.unwrap_or(scale(sum, T::of(1.0) / T::of(ring.len() as f64)));
    for (g, at) in ring {
        let sheet = &mut sheets[*g as usize];
        let (half, list) = (sheet.half, of(sheet));
        (0..3).for_each(|c| list[*at as usize + 2 * c * half] = mean[c]);
    }
}
