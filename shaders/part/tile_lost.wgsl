// Remainders too small for positions, of each particle; a tile writes those of its own elsewhere.
@group(0) @binding(36) var<storage, read_write> losing: array<vec4<f32>>;

fn lose(k: u32, what: vec4<f32>) {
  if (own) {
    losing[k] = what;
  }
}

// Of a particle that does not move.
fn stay_lost(k: u32) {
  lose(k, lost_at(k));
}
