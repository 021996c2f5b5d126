// Notes of a workgroup, beside its cloth's faults: its memory is full of positions.
fn noted(n: u32) -> u32 {
  return atomicLoad(&faults[FAULT_STRIDE * row + FAULT_NOTES + n]);
}

fn note(n: u32, x: u32) {
  atomicStore(&faults[FAULT_STRIDE * row + FAULT_NOTES + n], x);
}

fn note_least(n: u32, x: u32) {
  // Few are beyond all before.
  if (x < atomicLoad(&faults[FAULT_STRIDE * row + FAULT_NOTES + n])) {
    atomicMin(&faults[FAULT_STRIDE * row + FAULT_NOTES + n], x);
  }
}

fn note_most(n: u32, x: u32) {
  if (x > atomicLoad(&faults[FAULT_STRIDE * row + FAULT_NOTES + n])) {
    atomicMax(&faults[FAULT_STRIDE * row + FAULT_NOTES + n], x);
  }
}

fn note_bits(n: u32, x: u32) {
  atomicOr(&faults[FAULT_STRIDE * row + FAULT_NOTES + n], x);
}

fn noted_all() {
  storageBarrier();
}
