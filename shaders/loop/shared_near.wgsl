// A rule of particles that asks for the colliders near a workgroup's particles, for several cloths.
@compute @workgroup_size(64)
fn main(
  @builtin(workgroup_id) workgroup: vec3<u32>,
  @builtin(num_workgroups) rows: vec3<u32>,
  @builtin(local_invocation_index) local: u32,
) {
  member(workgroup.z);
  let n = element(workgroup, rows, local);
  clear_faults(n == 0u);
  let k = cloth.first + n;
  var p = vec4<f32>(0.0);
  var earlier = vec3<f32>(0.0);
  if (n < cloth.count) {
    p = place(k);
    earlier = was(k);
  }
  let free = p.w > 0.0;
  let low = select(vec3<f32>(1.0), min(p.xyz, earlier), free);
  gather(low, select(vec3<f32>(0.0), max(p.xyz, earlier), free), local, 64u);
  if (free) {
    each(k);
  }
}
