// Remainders too small for positions, of each particle, where they lie.
fn lose(k: u32, what: vec4<f32>) {
  set_lost(k, what);
}
