// A rule of particles in a whole frame.
fn each_all(job: Job, local: u32) {
  for (var k = job.first + local; k < job.first + job.count; k += threads) {
    each(k);
  }
}
