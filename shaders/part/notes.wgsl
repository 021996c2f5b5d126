// Notes of a workgroup, in its memory.
var<workgroup> notes: array<atomic<u32>, 38>;

fn noted(n: u32) -> u32 {
  return atomicLoad(&notes[n]);
}

fn note(n: u32, x: u32) {
  atomicStore(&notes[n], x);
}

fn note_least(n: u32, x: u32) {
  // Few are beyond all before.
  if (x < atomicLoad(&notes[n])) {
    atomicMin(&notes[n], x);
  }
}

fn note_most(n: u32, x: u32) {
  if (x > atomicLoad(&notes[n])) {
    atomicMax(&notes[n], x);
  }
}

fn note_bits(n: u32, x: u32) {
  atomicOr(&notes[n], x);
}

fn noted_all() {
  workgroupBarrier();
}
