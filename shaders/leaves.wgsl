// Boxes around the particles of each tile of 4 x 4, and how far these may move until the next search. Two vectors per box: its low corner
// and that reach, and its high corner. One thread per texel; the first of each tile works.
@group(0) @binding(2) var<storage, read> now: array<vec4<f32>>;
@group(0) @binding(3) var<storage, read> before: array<vec4<f32>>;
@group(0) @binding(67) var<storage, read> kin: array<u32>;
@group(0) @binding(69) var<storage, read_write> boxes: array<vec4<f32>>;

@compute @workgroup_size(16, 4)
fn main(@builtin(global_invocation_id) id: vec3<u32>) {
  let grid = grids[id.z];
  if (id.x >= grid.width || id.y >= grid.height || (id.x | id.y) % 4u != 0u) {
    return;
  }
  let distance = bitcast<f32>(kin[0]);
  var low = vec3<f32>(FARTHEST);
  var high = vec3<f32>(-FARTHEST);
  var fastest = 0.0;
  for (var n = 0u; n < 16u; n++) {
    let cell = id.xy + vec2<u32>(n % 4u, n / 4u);
    if (cell.x < grid.width && cell.y < grid.height) {
      let k = grid.first + cell.y * grid.width + cell.x;
      let p = now[k];
      if (p.w >= 0.0) {
        let step = p.xyz - before[k].xyz;
        low = min(low, p.xyz);
        high = max(high, p.xyz);
        fastest = max(fastest, dot(step, step));
      }
    }
  }
  let reach = min(max(sqrt(fastest) * STEPS_AHEAD, distance * MIN_REACH), distance * MAX_REACH);
  let wide = vec3<f32>(distance * 0.5 + reach);
  let tiles = kin[kin[kin[2] + 2u * id.z]];
  let node = tiles + id.y / 4u * ((grid.width + 3u) / 4u) + id.x / 4u;
  boxes[2u * node] = vec4<f32>(low - wide, reach);
  boxes[2u * node + 1u] = vec4<f32>(high + wide, 0.0);
}
