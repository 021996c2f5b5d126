// Nothing is lost.
fn stay_lost(k: u32) {}
