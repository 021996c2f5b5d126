// The Laplacian at a seam point is the sum of what its duplicates see; without one of them there is none.
fn join_moments(ring: u32) {
  let first = starts[ring];
  let end = starts[ring + 1u];
  var sum = vec3<f32>(0.0);
  var whole = true;
  for (var m = first; m < end; m++) {
    let p = moments[members[m]];
    sum += p.xyz;
    whole = whole && p.w > 0.0;
  }
  for (var m = first; m < end; m++) {
    moments[members[m]] = select(vec4<f32>(0.0), vec4<f32>(sum, 1.0), whole);
  }
}
