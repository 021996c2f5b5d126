// The largest squared displacement of the last step, as bits, which are ordered as numbers that are not below 0 are.
fn speed_all(job: Job, local: u32) {
  var far = 0.0;
  for (var k = job.first + local; k < job.first + job.count; k += threads) {
    let p = now[k];
    let d = p.xyz - before[k].xyz;
    if (p.w > 0.0) {
      far = larger(far, dot(d, d));
    }
  }
  far = most_of_all(far, local);
  if (local == 0u) {
    atomicMax(&faults[FAULT_STRIDE * row + FAULT_SPEED], bitcast<u32>(far));
  }
}
