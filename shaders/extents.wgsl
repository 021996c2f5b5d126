// Boxes around all that the particles of each tile of 4 x 4 pass until the next search, of all cloths with contact. Two vectors per box: its
// low corner and its high corner. One thread per tile. `part` has the time until then.
@group(0) @binding(53) var<uniform> part: vec4<f32>;
@group(0) @binding(67) var<storage, read> kin: array<u32>;
@group(0) @binding(69) var<storage, read_write> boxes: array<vec4<f32>>;
@group(0) @binding(77) var<storage, read> shadows: array<vec4<f32>>;

const NOBODY: u32 = 0xffffffffu;

@compute @workgroup_size(64)
fn main(
  @builtin(workgroup_id) workgroup: vec3<u32>,
  @builtin(num_workgroups) rows: vec3<u32>,
  @builtin(local_invocation_index) local: u32,
) {
  let tile = element(workgroup, rows, local);
  if (tile >= kin[4]) {
    return;
  }
  let g = kin[kin[6] + 2u * tile];
  let corner = kin[kin[6] + 2u * tile + 1u];
  let grid = grids[g];
  var low = vec3<f32>(FARTHEST);
  var high = vec3<f32>(-FARTHEST);
  for (var n = 0u; n < 16u; n++) {
    let cell = vec2<u32>(corner & 0xffffu, corner >> 16u) * 4u + vec2<u32>(n % 4u, n / 4u);
    if (cell.x < grid.width && cell.y < grid.height) {
      let k = grid.first + cell.y * grid.width + cell.x;
      if (kin[kin[3] + k] != NOBODY) {
        let at = shadows[2u * k].xyz;
        let end = at + shadows[2u * k + 1u].xyz * part.x;
        low = min(low, min(at, end));
        high = max(high, max(at, end));
      }
    }
  }
  let wide = bitcast<f32>(kin[kin[7] + 8u * g + 1u]) * SHADOW_WIDTH;
  boxes[2u * tile] = vec4<f32>(low - wide, 0.0);
  boxes[2u * tile + 1u] = vec4<f32>(high + wide, 0.0);
}
