// Of a particle nothing is in registers but where it was.
fn take_own(k: u32) {}
