// A way out for springs that have almost no length: from the number of its texel, it looks random, and is always the same.
// See crates/runtime/src/cpu/aside.rs.

fn way(texel: u32) -> vec3<f32> {
  let state = texel * 747796405u + 2891336453u;
  let word = ((state >> ((state >> 28u) + 4u)) ^ state) * 277803737u;
  let hash = (word >> 22u) ^ word;
  return vec3<f32>(vec3<u32>(hash, hash >> 10u, hash >> 20u) & vec3<u32>(1023u)) / 512.0 - 1.0;
}
