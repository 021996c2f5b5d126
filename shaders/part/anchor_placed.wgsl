// Anchors lie where all particles do.
fn anchor(k: u32) -> vec4<f32> {
  return place(k);
}
