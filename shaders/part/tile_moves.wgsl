// A tile begins with the step itself: now becomes before.
// Until all particles have moved, the step before is the last one; then it is this one.
fn was(k: u32) -> vec3<f32> {
  if (arriving) {
    return earlier(k);
  }
  return now[k].xyz;
}

fn set_was(k: u32, p: vec4<f32>) {
  if (own) {
    pass_on(k, p);
  }
}

// Of a particle that does not move.
fn stay(k: u32) {
  if (own) {
    carry(k);
  }
  stay_lost(k);
}
