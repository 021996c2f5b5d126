// Air whose effect on triangles the pass `wind` has worked out.
fn acceleration(k: u32, p: vec3<f32>, moved: vec3<f32>) -> vec3<f32> {
  return step.gravity + field_at(k).xyz;
}
