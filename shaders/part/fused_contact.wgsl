// Particles leave the colliders.
fn contact_all(job: Job, local: u32) {
  first_solid = job.solid;
  gather_all(job, local);
  for (var k = job.first + local; k < job.first + job.count; k += threads) {
    let p = place(k);
    if (p.w > 0.0) {
      put(k, vec4<f32>(cleared(p.xyz, was(k)), p.w));
    }
  }
  sync();
}
