//! Twin of shaders/prolong.wgsl: the motion of a finer image, from that of the coarser one.

use crate::coarser::{Beside, Motion, Table};
use crate::number::real::{add, scale, with_w};

/// Puts the particles of a fine image on the triangles of the coarser one, and pins between coarse texels beside theirs. On entry `fine`
/// has the inverse masses.
pub fn run(table: &Table, coarse: &Motion, beside: &Beside, fine: &mut Motion) {
    for k in 0..fine.now.len() {
        let (of, weights) = table.stencil(k);
        let at = |list: &[[f32; 4]]| {
            let part = |c: usize| scale([0, 1, 2].map(|d| list[of[c]][d]), weights[c]);
            with_w(add(add(part(0), part(1)), part(2)), fine.now[k][3])
        };
        let (now, before) = (at(&coarse.now), at(&coarse.before));
        (fine.now[k], fine.before[k]) = (now, before);
    }
    for (k, c, way) in beside {
        let (k, c) = (*k as usize, *c as usize);
        let at = |list: &[[f32; 4]]| with_w(add([0, 1, 2].map(|d| list[c][d]), *way), fine.now[k][3]);
        let (now, before) = (at(&coarse.now), at(&coarse.before));
        (fine.now[k], fine.before[k]) = (now, before);
    }
}
