// Drops what is too small for the position of a particle that is put somewhere.
fn clear_lost(k: u32) {
  set_lost(k, vec4<f32>(0.0));
}
