// A rule of particles in a whole frame.
fn each_all(job: Job, local: u32) {
  for (mine = 0u; has_more(job.count); mine++) {
    let k = job.first + local + mine * threads;
    if (k < job.first + job.count) {
      each(k);
    }
  }
}
