// Duplicates of a seam point take the sum of their normals, so that no seam shows.
fn join_normals(ring: u32) {
  var sum = vec3<f32>(0.0);
  for (var m = starts[ring]; m < starts[ring + 1u]; m++) {
    let n = normals[members[m]];
    sum += n.xyz * n.w;
  }
  let normal = unit(sum);
  for (var m = starts[ring]; m < starts[ring + 1u]; m++) {
    normals[members[m]] = normal;
  }
}
