// So few colliders that all are tried.
fn gather(low: vec3<f32>, high: vec3<f32>, local: u32, threads: u32) {}

fn near_from(c: u32) -> u32 {
  return c;
}

fn near_to(c: u32, at: vec3<f32>, was: vec3<f32>) -> u32 {
  return c;
}
