// The multipliers of the last step end with it.
fn forget_all(job: Job, local: u32) {
  for (var k = job.first + local; k < job.first + job.count; k += threads) {
    sums[k] = vec4<f32>(0.0);
  }
  storageBarrier();
}
