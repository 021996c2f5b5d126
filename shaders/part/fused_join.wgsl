// The normals of the duplicates of every seam point become one.
fn join_all(job: Job, local: u32) {
  storageBarrier();
  for (var r = job.ring + local; r < job.ring + job.rings; r += threads) {
    join_normals(r);
  }
}
