// Stitches as `Sewing::rows` in crates/runtime/src/cloth/stitch.rs lays them out: three rows per particle.

// No stitch, or the end of a list.
const NO_STITCH: u32 = 0xffffffffu;
// Stitches at a point, at most.
const MOST_STITCHES: u32 = 32u;

// The shares of the corners of the quad in the point, from the second row.
fn shares_of(more: vec4<u32>) -> vec4<f32> {
  let at = bitcast<vec2<f32>>(more.xy);
  let rest = vec2<f32>(1.0) - at;
  return vec4<f32>(rest.x * rest.y, at.x * rest.y, rest.x * at.y, at.x * at.y);
}

// How many stitches move an end.
fn count_of(counts: u32, end: u32) -> f32 {
  return f32((counts >> (6u * end)) & 63u);
}
