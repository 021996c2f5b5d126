// Remainders too small for positions, of each particle, where it lies.
fn lose(k: u32, what: vec4<f32>) {
  set_lost(k, what);
}
