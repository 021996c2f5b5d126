// Finds the colliders near all particles that a workgroup works for.
fn find_near(ring: u32, work: vec3<u32>, local: u32) {
  var least = vec3<f32>(3e38);
  var most = vec3<f32>(-3e38);
  for (var m = work.x; m < work.y; m++) {
    let k = link(ring, m, work.z);
    let p = place(k);
    if (p.w > 0.0) {
      let earlier = was(k);
      least = min(least, min(p.xyz, earlier));
      most = max(most, max(p.xyz, earlier));
    }
  }
  gather(least, most, local, 64u);
}
