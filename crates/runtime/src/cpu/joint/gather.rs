//! Twin of shaders/gather.wgsl: where a step takes the particles of a cloth.

use super::Lists;
use crate::cpu::guard::is_sane;
use crate::number::real::{Real, with_w, xyz};

/// Takes in the particles of a cloth that begins at a place of the lists; `begins`: as a frame begins, when free ones are there already; `put`: pins too.
pub fn run<T: Real>(lists: &mut Lists<T>, first: usize, now: &[[T; 4]], [begins, put, sleeps]: [bool; 3]) {
    for (k, p) in now.iter().enumerate() {
        let goal = if is_sane(xyz(*p)) { xyz(*p) } else { xyz(lists.places[first + k]) };
        let mark = match p[3] {
            w if w < T::of(0.0) => -1.0,
            w if w > T::of(0.0) && !sleeps => 1.0,
            _ => 0.0,
        };
        lists.goals[first + k] = with_w(goal, T::of(mark));
        if begins && (put || p[3] > T::of(0.0)) {
            lists.places[first + k] = with_w(goal, T::of(mark));
        }
    }
}
