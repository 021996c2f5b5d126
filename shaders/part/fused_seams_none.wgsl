// Cloth without seams.
fn seam_all(job: Job, local: u32) {}
