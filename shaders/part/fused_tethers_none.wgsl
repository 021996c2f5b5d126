// Cloth that hangs on nothing.
fn tether_all(job: Job, local: u32) {}
