// No multiplier to go on from.
fn take_sums(k: u32, at: u32) {}

fn give_sums(k: u32, at: u32) {}
