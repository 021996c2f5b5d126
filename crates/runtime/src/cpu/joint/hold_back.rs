//! Twin of shaders/hold_back.wgsl: puts the particles of a cloth that were held back. The CPU backend does so in
//! [`crate::cpu::fabric::Fabric::hold_back`].

use super::Lists;
use crate::cpu::guard::is_sane;
use crate::number::real::{Real, add, dot, scale, sub, with_w, xyz};

/// Puts those of a cloth that begins at a place of the lists.
pub fn run<T: Real>(lists: &Lists<T>, first: usize, now: &mut [[T; 4]], before: &mut [[T; 4]]) {
    for (k, (p, was)) in now.iter_mut().zip(before).enumerate() {
        let change = sub(xyz(lists.places[first + k]), xyz(*p));
        let long = dot(change, change).sqrt();
        if p[3] > T::of(0.0) && is_sane(xyz(*p)) && long > T::of(0.0) {
            let ahead = dot(sub(xyz(*p), xyz(*was)), change) / long;
            let follows = (ahead + long).max(T::of(0.0)).min(long) / long;
            *p = with_w(xyz(lists.places[first + k]), p[3]);
            *was = with_w(add(xyz(*was), scale(change, follows)), was[3]);
        }
    }
}
