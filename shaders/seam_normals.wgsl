// Duplicates of a seam point take the sum of their normals, so that no seam shows. A thread a ring.
@group(0) @binding(8) var<storage, read_write> normals: array<vec4<f32>>;

@compute @workgroup_size(64)
fn main(
  @builtin(workgroup_id) workgroup: vec3<u32>,
  @builtin(num_workgroups) rows: vec3<u32>,
  @builtin(local_invocation_index) local: u32,
) {
  let ring = element(workgroup, rows, local);
  if (ring + 1u >= arrayLength(&starts)) {
    return;
  }
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
