// What a workgroup finds out, beside its cloth's faults: its memory is full of positions.
fn noted(n: u32) -> u32 {
  return atomicLoad(&faults[64u * row + 8u + n]);
}

fn note(n: u32, x: u32) {
  atomicStore(&faults[64u * row + 8u + n], x);
}

fn note_least(n: u32, x: u32) {
  // Few are beyond all before.
  if (x < atomicLoad(&faults[64u * row + 8u + n])) {
    atomicMin(&faults[64u * row + 8u + n], x);
  }
}

fn note_most(n: u32, x: u32) {
  if (x > atomicLoad(&faults[64u * row + 8u + n])) {
    atomicMax(&faults[64u * row + 8u + n], x);
  }
}

fn note_bits(n: u32, x: u32) {
  atomicOr(&faults[64u * row + 8u + n], x);
}

fn noted_all() {
  storageBarrier();
}
