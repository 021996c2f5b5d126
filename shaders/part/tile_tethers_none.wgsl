// No tethers.
fn hold(k: u32, p: vec4<f32>) -> vec4<f32> {
  return p;
}

fn hold_all(local: u32) {}
