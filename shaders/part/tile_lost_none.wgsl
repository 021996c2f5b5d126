// Nothing is lost.
fn stay(k: u32) {}
