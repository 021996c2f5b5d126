// So few colliders that all are tried.
fn gather_all(job: Job, local: u32) {}
