// Air whose effect on triangles the pass `wind` has worked out.
@group(0) @binding(9) var<storage, read> field: array<vec4<f32>>;

fn acceleration(k: u32, p: vec3<f32>, moved: vec3<f32>) -> vec3<f32> {
  return step.gravity + field[k].xyz;
}
