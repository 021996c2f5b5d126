// Nobody asks for normals.
fn normal_all(job: Job, local: u32) {}
