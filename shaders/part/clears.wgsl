// The counters of a frame begin at 0, in its first dispatch.
fn clear_faults(first: bool) {
  if (first && part.z == 1u) {
    atomicStore(&faults[fault(FAULT_PARTICLES)], 0u);
    atomicStore(&faults[fault(FAULT_SPEED)], 0u);
    atomicStore(&faults[fault(FAULT_STRAIN)], 0u);
  }
}
