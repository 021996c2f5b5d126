// A tile that begins with a step, or within one.
fn end_last_step(local: u32) {}

fn taken(k: u32) -> vec4<f32> {
  let p = now[k];
  put(k, p);
  return p;
}

// Pinned particles stay in place. `k` counts those of the cloth.
fn anchor(k: u32) -> vec4<f32> {
  return now[base + k];
}
