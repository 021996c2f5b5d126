// No texture coordinates.
fn texture(t: vec3<u32>, corner: u32) -> vec2<f32> {
  return vec2<f32>(0.0);
}
