// Triangles that are cut away, by texel: bit 0 is that of corners 0, 1, 2 of the quad, bit 1 that of 0, 2, 3.
fn removed(k: u32) -> u32 {
  return holes_at(k);
}
