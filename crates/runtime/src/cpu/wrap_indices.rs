//! Twin of shaders/wrap_indices.wgsl: the triangles of a bound mesh that are left of a cloth that was cut.

/// Makes a point of each triangle that covers a triangle of the cloth that is cut away. `covers` are pairs: twice the texel of a quad, plus 1
/// for its second triangle, and a triangle of the mesh.
pub fn run(covers: &[[u32; 2]], holes: &[u32], indices: &mut [u32]) {
    for [covered, triangle] in covers {
        if holes[(covered >> 1) as usize] >> (covered & 1) & 1 == 1 {
            let t = 3 * *triangle as usize;
            (indices[t + 1], indices[t + 2]) = (indices[t], indices[t]);
        }
    }
}
