// A rule of particles for several cloths: a thread a particle, a layer of workgroups a cloth.
@compute @workgroup_size(64)
fn main(
  @builtin(workgroup_id) workgroup: vec3<u32>,
  @builtin(num_workgroups) rows: vec3<u32>,
  @builtin(local_invocation_index) local: u32,
) {
  member(workgroup.z);
  let n = element(workgroup, rows, local);
  clear_faults(n == 0u);
  if (n < cloth.count) {
    each(cloth.first + n);
  }
}
