// Nobody watches for rest.
fn speed_all(job: Job, local: u32) {}
