// The largest squared displacement of the last step among 64 particles. A NaN counts as fast: no such cloth is at rest.
@group(0) @binding(2) var<storage, read> now: array<vec4<f32>>;
@group(0) @binding(3) var<storage, read> before: array<vec4<f32>>;
@group(0) @binding(15) var<storage, read_write> partial: array<f32>;

@compute @workgroup_size(64)
fn main(
  @builtin(workgroup_id) workgroup: vec3<u32>,
  @builtin(num_workgroups) rows: vec3<u32>,
  @builtin(local_invocation_index) local: u32,
) {
  let k = element(workgroup, rows, local);
  var far = 0.0;
  if (k < arrayLength(&now)) {
    let p = now[k];
    let d = p.xyz - before[k].xyz;
    if (p.w > 0.0) {
      far = dot(d, d);
    }
  }
  far = most(far, local);
  let n = workgroup.y * rows.x + workgroup.x;
  if (local == 0u && n < arrayLength(&partial)) {
    partial[n] = far;
  }
}
