// There is no collider.
fn contact_all(job: Job, local: u32) {}
