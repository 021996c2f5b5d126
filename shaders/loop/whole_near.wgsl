// A rule of particles that asks for the colliders near a cloth, in a whole frame.
fn each_all(job: Job, local: u32) {
  var low = vec3<f32>(3e38);
  var high = vec3<f32>(-3e38);
  for (mine = 0u; has_more(job.count); mine++) {
    let k = job.first + local + mine * threads;
    if (k < job.first + job.count) {
      let p = place(k);
      if (p.w > 0.0) {
        let earlier = was(k);
        low = min(low, min(p.xyz, earlier));
        high = max(high, max(p.xyz, earlier));
      }
    }
  }
  gather(low, high, local, threads);
  for (mine = 0u; has_more(job.count); mine++) {
    let k = job.first + local + mine * threads;
    if (k < job.first + job.count) {
      each(k);
    }
  }
}
