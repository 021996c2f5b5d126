// Stitches as paths, behind the links of seams: where those of each texel begin, one entry more than there are texels, then per end the
// texel at the other end, the bits of the length of the path, and the first texel of the quad, without which the path is gone.

fn bridges_from(k: u32) -> u32 {
  return mates[texels() + k];
}

fn bridge_to(e: u32) -> u32 {
  return mates[2u * texels() + 1u + 3u * e];
}

// 0 where the quad has lost a triangle.
fn bridge_length(e: u32) -> f32 {
  let at = 2u * texels() + 1u + 3u * e;
  return select(0.0, bitcast<f32>(mates[at + 1u]), rest[mates[at + 2u]].z > 0.0);
}
