//! Twin of shaders/indices.wgsl: the triangles of a cloth, as index buffers have them.

use super::neighbours::View;
use crate::number::real::Real;

/// Indices per texel: two triangles.
pub const PER_TEXEL: usize = 6;

/// The triangles of each quad of one grid whose first particle is `first`, six indices per texel: those of [`View::quad`],
/// and a point for each that is not there.
pub fn run<T: Real>(view: View<T>, first: u32, indices: &mut [u32]) {
    for (k, out) in indices.chunks_exact_mut(PER_TEXEL).enumerate() {
        let (count, corners) = view.quad(k % view.width, k / view.width);
        let bits = view.removed(k);
        for (n, out) in out.chunks_exact_mut(3).enumerate() {
            let there = n < count as usize && bits >> n & 1 == 0;
            // The corners of a quad turn clockwise, seen from the side that normals point to.
            let corners = if there { [0, 2, 1].map(|c| corners[n][c]) } else { [k; 3] };
            (0..3).for_each(|c| out[c] = first + corners[c] as u32);
        }
    }
}

/// The same without points.
pub fn triangles(indices: &[u32]) -> Vec<u32> {
    let there = |t: &&[u32]| t[0] != t[1];
    indices.chunks_exact(3).filter(there).flatten().copied().collect()
}
