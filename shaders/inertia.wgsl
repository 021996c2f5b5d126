// The motion of a frame of reference changes the velocities of free particles: the columns of a matrix for displacements, those of
// one for positions, and a shift.
@group(0) @binding(2) var<storage, read> now: array<vec4<f32>>;
@group(0) @binding(3) var<storage, read_write> before: array<vec4<f32>>;

fn columns(n: u32, v: vec3<f32>) -> vec3<f32> {
  return action[n].xyz * v.x + action[n + 1u].xyz * v.y + action[n + 2u].xyz * v.z;
}

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
    let b = before[k];
    let moved = columns(0u, p.xyz - b.xyz) + columns(3u, p.xyz) + action[6].xyz;
    before[k] = vec4<f32>(p.xyz - moved, b.w);
  }
}
