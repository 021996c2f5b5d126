// No multiplier is kept.
fn forget_all(job: Job, local: u32) {}
