// Puts chosen particles at given positions, at rest, and gives them other inverse masses.
@group(0) @binding(2) var<storage, read_write> now: array<vec4<f32>>;
@group(0) @binding(3) var<storage, read_write> before: array<vec4<f32>>;
// The particle, with PLACE_MOVES and PLACE_WEIGHS, and its row of `action`: position and inverse mass.
@group(0) @binding(12) var<storage, read> chosen: array<vec2<u32>>;

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
  let row = chosen[n];
  let k = row.x & ~(PLACE_MOVES | PLACE_WEIGHS);
  let to = action[row.y];
  let p = now[k];
  let b = before[k];
  let moves = (row.x & PLACE_MOVES) != 0u;
  let weighs = (row.x & PLACE_WEIGHS) != 0u;
  now[k] = vec4<f32>(select(p.xyz, to.xyz, moves), select(p.w, to.w, weighs));
  before[k] = vec4<f32>(select(b.xyz, to.xyz, moves), select(b.w, to.w, weighs));
}
