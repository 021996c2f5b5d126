// Moves chosen particles by a matrix, and their previous positions alike, so that velocities turn with them.
@group(0) @binding(12) var<storage, read> chosen: array<u32>;

fn moved(p: vec4<f32>) -> vec4<f32> {
  return vec4<f32>(action[0].xyz * p.x + action[1].xyz * p.y + action[2].xyz * p.z + action[3].xyz, p.w);
}

fn act(n: u32) {
  let k = chosen[n];
  now[k] = moved(now[k]);
  before[k] = moved(before[k]);
}
