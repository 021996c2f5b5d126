// The multipliers of the duplicates of every seam point become one. A thread a ring.
@group(0) @binding(27) var<storage, read_write> moments: array<vec4<f32>>;

@compute @workgroup_size(64)
fn main(
  @builtin(workgroup_id) workgroup: vec3<u32>,
  @builtin(num_workgroups) rows: vec3<u32>,
  @builtin(local_invocation_index) local: u32,
) {
  let ring = element(workgroup, rows, local);
  if (ring + 1u < arrayLength(&starts)) {
    join_moments(ring);
  }
}
