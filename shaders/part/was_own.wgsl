// Positions one step before, in registers of the thread that has the particle in every pass, until the frame ends.
var<private> own_before: array<vec3<f32>, PER_THREAD>;

// Whether a thread may have more particles. Their number is a constant, so that compilers unroll the loop, and arrays lie in registers.
fn has_more(count: u32) -> bool {
  return mine < PER_THREAD;
}

fn was(k: u32) -> vec3<f32> {
  return own_before[mine];
}

fn set_was(k: u32, p: vec4<f32>) {
  own_before[mine] = p.xyz;
}

fn take_was(k: u32) {
  own_before[mine] = before[k].xyz;
}

fn give_was(k: u32, w: f32) {
  before[k] = vec4<f32>(own_before[mine], w);
}
