// The target of a limit, which stays where it is.
fn aim(k: u32) -> vec4<f32> {
  return targets_at(k);
}
