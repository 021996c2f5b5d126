// A tile begins with the step itself: now becomes before, elsewhere.
@group(0) @binding(3) var<storage, read> before: array<vec4<f32>>;
@group(0) @binding(35) var<storage, read_write> passed: array<vec4<f32>>;

// Until all particles have moved, the step before is the last one; then it is this one.
fn was(k: u32) -> vec3<f32> {
  if (arriving) {
    return before[k].xyz;
  }
  return now[k].xyz;
}

fn set_was(k: u32, p: vec4<f32>) {
  if (own) {
    passed[k] = p;
  }
}

// Of a particle that does not move.
fn stay(k: u32) {
  if (own) {
    passed[k] = before[k];
  }
  stay_lost(k);
}
