// The multiplier of bending at every texel.
@group(0) @binding(27) var<storage, read_write> moments: array<vec4<f32>>;

@compute @workgroup_size(16, 4)
fn main(@builtin(global_invocation_id) id: vec3<u32>) {
  let grid = grids[id.z];
  if (id.x >= grid.width || id.y >= grid.height) {
    return;
  }
  let k = grid.first + id.y * grid.width + id.x;
  moments[k] = moment_at(grid, id.xy, k);
}
