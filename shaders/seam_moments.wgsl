// The Laplacian at a seam point is the sum of what its duplicates see; without one of them there is none.
fn join_moments(ring: u32) {
  let first = starts_at(ring);
  let end = starts_at(ring + 1u);
  var sum = vec3<f32>(0.0);
  var whole = true;
  for (var m = first; m < end; m++) {
    let p = moments_at(members_at(m));
    sum += p.xyz;
    whole = whole && p.w > 0.0;
  }
  for (var m = first; m < end; m++) {
    set_moments(members_at(m), select(vec4<f32>(0.0), vec4<f32>(sum, 1.0), whole));
  }
}
