// Cloth of springs.
fn membrane_all(job: Job, local: u32) {}
