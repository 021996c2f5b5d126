//! Twin of shaders/sew.wgsl: particles follow what their stitches pull with.

use super::stitch::Stitches;
use crate::cpu::sheet::Sheet;
use crate::number::real::{Real, add, scale};

/// Moves every point by all its stitches; duplicates alike.
pub fn run<T: Real>(sheets: &mut [Sheet<T>], stitches: &Stitches<T>) {
    let zero = T::of(0.0);
    for (members, entries) in stitches.moved.iter().zip(&*stitches.entries) {
        let mut sum = [zero; 3];
        for (stitch, end) in entries {
            let (thread, pull) = (&stitches.threads[*stitch as usize], stitches.pulls[*stitch as usize]);
            let share = if *end == 4 { T::of(-1.0) } else { thread.shares[*end as usize] };
            sum = add(sum, scale(pull, share));
        }
        for member in members {
            let sheet = &mut sheets[member.sheet as usize];
            let w = sheet.w[member.single as usize];
            if w > zero {
                let to = add(sheet.at(member.at as usize), scale(sum, w));
                sheet.put(member.at as usize, to);
            }
        }
    }
}
