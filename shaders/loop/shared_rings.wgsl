// A rule of seam rings for several cloths: a thread a ring, a layer of workgroups a cloth.
@compute @workgroup_size(64)
fn main(
  @builtin(workgroup_id) workgroup: vec3<u32>,
  @builtin(num_workgroups) rows: vec3<u32>,
  @builtin(local_invocation_index) local: u32,
) {
  member(workgroup.z);
  let n = element(workgroup, rows, local);
  clear_faults(n == 0u);
  if (n < cloth.rings) {
    each(cloth.ring + n);
  }
}
