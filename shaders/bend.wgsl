// Every free particle follows the multipliers of bending. A thread a texel.
@group(0) @binding(27) var<storage, read> moments: array<vec4<f32>>;

@compute @workgroup_size(16, 4)
fn main(@builtin(global_invocation_id) id: vec3<u32>) {
  let grid = grids[id.z];
  if (id.x >= grid.width || id.y >= grid.height) {
    return;
  }
  let k = grid.first + id.y * grid.width + id.x;
  let p = now[k];
  if (p.w <= 0.0) {
    return;
  }
  now[k] = bent(grid, id.xy, k, p);
}
