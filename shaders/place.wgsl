// Puts chosen particles at given positions, at rest, and gives them other inverse masses.
// The particle, with PLACE_MOVES and PLACE_WEIGHS, and its row of `action`: position and inverse mass.
@group(0) @binding(12) var<storage, read> chosen: array<vec2<u32>>;

fn act(n: u32) {
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
