// Particles go where contact with cloth pushes them, and so do their previous positions.
@group(0) @binding(2) var<storage, read_write> now: array<vec4<f32>>;
@group(0) @binding(3) var<storage, read_write> before: array<vec4<f32>>;
@group(0) @binding(71) var<storage, read> pushes: array<vec4<f32>>;

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
  if (p.w > 0.0) {
    now[k] = p + pushes[2u * k];
    before[k] = before[k] + pushes[2u * k + 1u];
  }
}
