// A rule of particles as a pass of its own: a thread a particle. `each` stands for the rule, here and in all loops.
@compute @workgroup_size(64)
fn main(
  @builtin(workgroup_id) workgroup: vec3<u32>,
  @builtin(num_workgroups) rows: vec3<u32>,
  @builtin(local_invocation_index) local: u32,
) {
  let k = element(workgroup, rows, local);
  if (k < arrayLength(&now)) {
    each(k);
  }
}
