// Particles inside a collider go to its surface, collider by collider.
@group(0) @binding(2) var<storage, read_write> now: array<vec4<f32>>;

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
  var at = p.xyz;
  for (var c = 0u; c < solid_count(); c++) {
    let solid = solid_at(c);
    let out = leave(solid, at);
    if (out.inside) {
      let depth = out.at - at;
      at = rub(solid, out.at, out.normal, sqrt(dot(depth, depth)), previous(k));
    }
  }
  now[k] = vec4<f32>(at, p.w);
}
