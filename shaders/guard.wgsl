// Counts the particles whose position is NaN or out of bounds.
fn guard(k: u32) {
  let p = place(k);
  if (p.w >= 0.0 && !sane(p)) {
    atomicAdd(&faults[fault(FAULT_PARTICLES)], 1u);
    atomicMax(&faults[fault(FAULT_LAST)], k - base + 1u);
  }
}
