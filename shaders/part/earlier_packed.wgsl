// Positions one step before; those after the step lie elsewhere. Between the steps of a frame they are three numbers per particle, as
// only tiles like this one read them. Before and after the frame they are four.
@group(0) @binding(3) var<storage, read> before: array<f32>;
@group(0) @binding(35) var<storage, read_write> passed: array<f32>;

fn last_step() -> bool {
  return part.x + 1u >= frame.steps;
}

// Where the numbers of a particle begin. Those of a cloth stay among its own.
fn packed(k: u32) -> u32 {
  return 4u * base + 3u * (k - base);
}

fn earlier(k: u32) -> vec3<f32> {
  let at = select(packed(k), 4u * k, part.x == 0u);
  return vec3<f32>(before[at], before[at + 1u], before[at + 2u]);
}

fn pass_on(k: u32, p: vec4<f32>) {
  let last = last_step();
  let at = select(packed(k), 4u * k, last);
  passed[at] = p.x;
  passed[at + 1u] = p.y;
  passed[at + 2u] = p.z;
  if (last) {
    passed[at + 3u] = p.w;
  }
}

fn carry(k: u32) {
  pass_on(k, vec4<f32>(earlier(k), place(k).w));
}
