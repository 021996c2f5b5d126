// A rule of seam rings in a whole frame.
fn each_all(job: Job, local: u32) {
  for (var r = job.ring + local; r < job.ring + job.rings; r += threads) {
    each(r);
  }
}
