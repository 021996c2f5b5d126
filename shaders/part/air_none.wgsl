// No air.
fn acceleration(k: u32, p: vec3<f32>, moved: vec3<f32>) -> vec3<f32> {
  return step.gravity;
}
