// Particles inside a moving collider, or on its other side, go to its surface, collider by collider.
@compute @workgroup_size(64)
fn main(
  @builtin(workgroup_id) workgroup: vec3<u32>,
  @builtin(num_workgroups) rows: vec3<u32>,
  @builtin(local_invocation_index) local: u32,
) {
  let k = element(workgroup, rows, local);
  var p = vec4<f32>(0.0);
  var was = vec3<f32>(0.0);
  if (k < arrayLength(&now)) {
    p = now[k];
    was = previous(k);
  }
  let free = p.w > 0.0;
  gather(select(vec3<f32>(1.0), min(p.xyz, was), free), select(vec3<f32>(0.0), max(p.xyz, was), free), local, 64u);
  if (free) {
    now[k] = vec4<f32>(cleared(p.xyz, was), p.w);
  }
}
