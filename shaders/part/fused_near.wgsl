// Which colliders are near the cloth.
fn gather_all(job: Job, local: u32) {
  var low = vec3<f32>(3e38);
  var high = vec3<f32>(-3e38);
  for (var k = job.first + local; k < job.first + job.count; k += threads) {
    let p = place(k);
    if (p.w > 0.0) {
      let was = before[k].xyz;
      low = min(low, min(p.xyz, was));
      high = max(high, max(p.xyz, was));
    }
  }
  gather(low, high, local, threads);
}
