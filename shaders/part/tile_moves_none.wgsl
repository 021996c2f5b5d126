// Particles have moved already.
fn arrive(k: u32, p: vec4<f32>, mine: bool) -> vec4<f32> {
  return p;
}
