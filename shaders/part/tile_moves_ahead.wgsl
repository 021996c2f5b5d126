// A tile begins the first step of a frame, and goes on in every other, which the dispatch before has begun: now becomes before.
fn was(k: u32) -> vec3<f32> {
  if (arriving || part.x > 0u) {
    return earlier(k);
  }
  return now[k].xyz;
}

// Once: a frame of several steps begins the second of them in the same dispatch as the first.
fn set_was(k: u32, p: vec4<f32>) {
  if (own && (!arriving || last_step())) {
    pass_on(k, p);
  }
}

// Of a particle that does not move, or has moved already.
fn stay(k: u32) {
  if (own) {
    carry(k);
  }
  stay_lost(k);
}
