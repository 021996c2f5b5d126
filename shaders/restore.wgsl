// Where any particle is at fault the cloth goes back to the last good frame, at rest; else this frame is the good one.
@group(0) @binding(24) var<storage, read_write> good: array<vec4<f32>>;

fn restore(k: u32) {
  let p = now[k];
  if (atomicLoad(&faults[fault(FAULT_PARTICLES)]) == 0u) {
    good[k] = p;
    return;
  }
  if (k == base) {
    atomicAdd(&faults[fault(FAULT_FRAMES)], 1u);
  }
  let at = vec4<f32>(good[k].xyz, p.w);
  now[k] = at;
  before[k] = at;
}
