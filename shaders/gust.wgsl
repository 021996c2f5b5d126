// Velocity of the air at each particle, which stays with the particle for a frame.
fn gust(k: u32) {
  set_airs(k, vec4<f32>(air(place(k).xyz), 0.0));
}
