// Where any particle is at fault the cloth goes back to the last good frame, at rest; else this frame is the good one.
@group(0) @binding(2) var<storage, read_write> now: array<vec4<f32>>;
@group(0) @binding(3) var<storage, read_write> before: array<vec4<f32>>;
@group(0) @binding(23) var<storage, read_write> faults: array<u32, 4>;
@group(0) @binding(24) var<storage, read_write> good: array<vec4<f32>>;

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
  if (faults[FAULT_PARTICLES] == 0u) {
    good[k] = now[k];
    return;
  }
  if (k == 0u) {
    faults[FAULT_FRAMES] = faults[FAULT_FRAMES] + 1u;
  }
  let p = now[k];
  let at = good[k].xyz;
  now[k] = vec4<f32>(at, p.w);
  before[k] = vec4<f32>(at, p.w);
}
