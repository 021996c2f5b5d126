// Duplicates of a seam point take the sum of their normals, so that no seam shows.
fn join_normals(ring: u32) {
  let first = starts_at(ring);
  let end = starts_at(ring + 1u);
  var sum = vec3<f32>(0.0);
  for (var m = first; m < end; m++) {
    let n = normals[members_at(m)];
    sum += n.xyz * n.w;
  }
  let normal = unit(sum);
  for (var m = first; m < end; m++) {
    normals[members_at(m)] = normal;
  }
}
