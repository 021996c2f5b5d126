// The multipliers of the duplicates of every seam point become one.
fn join_moments_all(job: Job, local: u32) {
  for (var r = job.ring + local; r < job.ring + job.rings; r += threads) {
    join_moments(r);
  }
  storageBarrier();
}
