//! Twin of shaders/seams.wgsl: all duplicates of a seam point take one position.

use crate::number::real::{Real, V3, add, scale, with_w, xyz};

/// Every member of a ring takes the mean of all, or the position of the first pinned one. Not shared out: seams are
/// few.
pub fn run<T: Real>(now: &mut [[T; 4]], starts: &[u32], members: &[u32]) {
    for ring in starts.windows(2) {
        let ring = &members[ring[0] as usize..ring[1] as usize];
        let at = place(now, ring);
        for &k in ring {
            let w = now[k as usize][3];
            now[k as usize] = with_w(at, w);
        }
    }
}

fn place<T: Real>(now: &[[T; 4]], ring: &[u32]) -> V3<T> {
    let mut sum = [T::of(0.0); 3];
    for &k in ring {
        let p = now[k as usize];
        if p[3] == T::of(0.0) {
            return xyz(p);
        }
        sum = add(sum, xyz(p));
    }
    scale(sum, T::of(1.0) / T::of(ring.len() as f64))
}
