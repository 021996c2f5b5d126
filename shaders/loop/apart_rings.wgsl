// A rule of seam rings as a pass of its own: a thread a ring.
@compute @workgroup_size(64)
fn main(
  @builtin(workgroup_id) workgroup: vec3<u32>,
  @builtin(num_workgroups) rows: vec3<u32>,
  @builtin(local_invocation_index) local: u32,
) {
  let ring = element(workgroup, rows, local);
  if (ring + 1u < arrayLength(&starts)) {
    each(ring);
  }
}
