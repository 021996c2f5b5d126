// Every free particle is held back by its anchors.
fn tether_all(job: Job, local: u32) {
  for (var k = job.first + local; k < job.first + job.count; k += threads) {
    let p = place(k);
    if (p.w > 0.0) {
      put(k, vec4<f32>(held_back(k, p.xyz), p.w));
    }
  }
  sync();
}
