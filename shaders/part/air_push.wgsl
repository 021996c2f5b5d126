// Air that pushes every particle alike.
fn acceleration(k: u32, p: vec3<f32>, moved: vec3<f32>) -> vec3<f32> {
  return step.gravity + (air(p) - moved * step.rate) * step.response;
}
