// As integrate.wgsl, for cloth of a material: what is too small for a position to take up is not lost.
@group(0) @binding(3) var<storage, read_write> before: array<vec4<f32>>;

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
  let was = before[k].xyz;
  before[k] = p;
  now[k] = moved_on(k, p, was);
}
