// The largest squared displacement of the last step of each cloth, as bits, which are ordered as numbers that are not below 0 are.
@compute @workgroup_size(64)
fn main(
  @builtin(workgroup_id) workgroup: vec3<u32>,
  @builtin(num_workgroups) rows: vec3<u32>,
  @builtin(local_invocation_index) local: u32,
) {
  member(workgroup.z);
  let n = element(workgroup, rows, local);
  let k = cloth.first + n;
  var far = 0.0;
  if (n < cloth.count) {
    let p = now[k];
    let d = p.xyz - before[k].xyz;
    if (p.w > 0.0) {
      far = dot(d, d);
    }
  }
  far = most(far, local);
  if (local == 0u) {
    atomicMax(&faults[fault(FAULT_SPEED)], bitcast<u32>(far));
  }
}
