// No colliders, or in a pass of their own.
fn clear_of(k: u32, p: vec4<f32>) -> vec4<f32> {
  return p;
}

fn gather_all(local: u32, owned: vec2<u32>, columns: u32) {}
