// The duplicates of every seam point come together.
fn seam_all(job: Job, local: u32) {
  for (var r = job.ring + local; r < job.ring + job.rings; r += threads) {
    close(r);
  }
  sync();
}
