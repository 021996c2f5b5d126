// Moves chosen particles by a matrix, and their previous positions alike, so that velocities turn with them.
@group(0) @binding(2) var<storage, read_write> now: array<vec4<f32>>;
@group(0) @binding(3) var<storage, read_write> before: array<vec4<f32>>;
@group(0) @binding(12) var<storage, read> chosen: array<u32>;

fn moved(p: vec4<f32>) -> vec4<f32> {
  return vec4<f32>(action[0].xyz * p.x + action[1].xyz * p.y + action[2].xyz * p.z + action[3].xyz, p.w);
}

@compute @workgroup_size(64)
fn main(
  @builtin(workgroup_id) workgroup: vec3<u32>,
  @builtin(num_workgroups) rows: vec3<u32>,
  @builtin(local_invocation_index) local: u32,
) {
  let n = element(workgroup, rows, local);
  if (n >= arrayLength(&chosen)) {
    return;
  }
  let k = chosen[n];
  now[k] = moved(now[k]);
  before[k] = moved(before[k]);
}
