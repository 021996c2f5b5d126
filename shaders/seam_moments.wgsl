// The Laplacian at a seam point is the sum of what its duplicates see; without one of them there is none. A thread a ring.
@group(0) @binding(27) var<storage, read_write> moments: array<vec4<f32>>;

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
