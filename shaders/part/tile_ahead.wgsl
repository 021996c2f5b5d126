// A tile that begins the next step of the frame too, for what it owns. Its neighbours then read where that step has brought particles, and not
// where they were before, and each particle begins a step once, not once in every tile that has it.
fn arrive(k: u32) {
  if (part.x == 0u) {
    arrive_program(k);
  } else if (last_step()) {
    stay(k);
  }
}

fn end_step() {
  own = true;
  if (!last_step()) {
    begin(part.x + 1u, cloth);
  }
}

fn depart(k: u32) {
  if (!last_step()) {
    arrive_program(k);
  }
}
