// Cloth that bends freely.
fn bend_all(job: Job, local: u32) {}
