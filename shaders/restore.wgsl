// Where any particle is at fault the cloth goes back to the last good frame, at rest; else this frame is the good one.
fn restore(k: u32) {
  let p = place(k);
  if (atomicLoad(&faults[fault(FAULT_PARTICLES)]) == 0u) {
    set_good(k, p);
    return;
  }
  if (k == base) {
    atomicAdd(&faults[fault(FAULT_FRAMES)], 1u);
  }
  let at = vec4<f32>(good_at(k).xyz, p.w);
  put(k, at);
  // In whole frames positions lie elsewhere, and are back in their buffers already.
  now[k] = at;
  before[k] = at;
}
