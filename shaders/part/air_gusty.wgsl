// Velocity of the air at a particle, as the pass `gust` found it.
fn air_at(k: u32) -> vec3<f32> {
  return airs_at(k).xyz;
}
