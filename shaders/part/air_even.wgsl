// Velocity of air that moves alike everywhere.
fn air_at(k: u32) -> vec3<f32> {
  return step.wind;
}
