// Positions one step before, where they lie.
fn was(k: u32) -> vec3<f32> {
  return before[k].xyz;
}

fn set_was(k: u32, p: vec4<f32>) {
  before[k] = p;
}

fn take_was(k: u32) {}

fn give_was(k: u32, w: f32) {}
