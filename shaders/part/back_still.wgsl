// The sphere behind a particle, which stays where it is.
fn back(k: u32) -> vec4<f32> {
  return backs_at(k);
}
