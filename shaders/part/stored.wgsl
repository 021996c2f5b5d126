// Positions where they lie.
fn place(k: u32) -> vec4<f32> {
  return now[k];
}

fn put(k: u32, p: vec4<f32>) {
  now[k] = p;
}
