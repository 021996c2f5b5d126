// Positions one step before.
@group(0) @binding(3) var<storage, read> before: array<vec4<f32>>;

fn previous(k: u32) -> vec3<f32> {
  return before[k].xyz;
}
