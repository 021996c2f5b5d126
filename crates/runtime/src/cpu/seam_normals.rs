//! Twin of shaders/seam_normals.wgsl: duplicates take the sum of their normals, so that no seam shows.

use super::normals::unit;
use crate::number::real::{Real, add, scale, xyz};

/// Sums the normals of every ring by their weights and gives the result to all of its members.
pub fn run<T: Real>(normals: &mut [[T; 4]], starts: &[u32], members: &[u32]) {
    for ring in starts.windows(2) {
        let ring = &members[ring[0] as usize..ring[1] as usize];
        let mut sum = [T::of(0.0); 3];
        for &k in ring {
            let n = normals[k as usize];
            sum = add(sum, scale(xyz(n), n[3]));
        }
        let normal = unit(sum);
        for &k in ring {
            normals[k as usize] = normal;
        }
    }
}
