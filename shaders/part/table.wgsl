// How the particles of two images of a cloth correspond (crates/runtime/src/coarser/table.rs). Its head: particles of the finer and of
// the coarser image, where stencils and rows begin, colours of springs, and where their beginnings are.
@group(0) @binding(58) var<storage, read> table: array<u32>;
// Positions of the image that was left, now and one step before.
@group(0) @binding(59) var<storage, read> origin: array<vec4<f32>>;
@group(0) @binding(60) var<storage, read> origin_before: array<vec4<f32>>;

// The coarse particles that a fine one lies between, and their weights.
fn stencil_ends(fine: u32) -> vec3<u32> {
  let at = table[2] + 6u * fine;
  return vec3<u32>(table[at], table[at + 1u], table[at + 2u]);
}

fn stencil_weights(fine: u32) -> vec3<f32> {
  let at = table[2] + 6u * fine + 3u;
  return bitcast<vec3<f32>>(vec3<u32>(table[at], table[at + 1u], table[at + 2u]));
}
