// Anchors lie where all particles of the cloth do.
fn anchor(k: u32) -> vec4<f32> {
  return place(base + k);
}

// The tethers of a particle, in registers of the thread that has it in every pass.
var<private> own_tethers: array<vec2<u32>, PER_THREAD * SLOTS>;

fn tether_pair(k: u32, s: u32) -> vec2<u32> {
  return own_tethers[mine * SLOTS + s];
}

fn take_own(k: u32) {
  for (var s = 0u; s < SLOTS; s++) {
    own_tethers[mine * SLOTS + s] = tethers_at(k * SLOTS + s);
  }
}
