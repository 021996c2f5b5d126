// Positions one step before, only to be read.
@group(0) @binding(3) var<storage, read> before: array<vec4<f32>>;

fn was(k: u32) -> vec3<f32> {
  return before[k].xyz;
}
