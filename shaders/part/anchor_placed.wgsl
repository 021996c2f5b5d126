// Anchors lie where all particles of the cloth do.
fn anchor(k: u32) -> vec4<f32> {
  return place(base + k);
}
