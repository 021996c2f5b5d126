// Particles have moved already.
fn stay(k: u32) {}
