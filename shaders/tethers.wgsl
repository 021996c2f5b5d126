// Every free particle is held back by its anchors. A thread a particle.
@compute @workgroup_size(64)
fn main(
  @builtin(workgroup_id) workgroup: vec3<u32>,
  @builtin(num_workgroups) rows: vec3<u32>,
  @builtin(local_invocation_index) local: u32,
) {
  let k = element(workgroup, rows, local);
  if (k >= arrayLength(&now)) {
    return;
  }
  let p = now[k];
  if (p.w <= 0.0) {
    return;
  }
  now[k] = vec4<f32>(held_back(k, p.xyz), p.w);
}
