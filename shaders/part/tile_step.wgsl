// A tile that begins no other step than its own.
fn arrive(k: u32) {
  arrive_program(k);
}

fn end_step() {}

fn depart(k: u32) {}
