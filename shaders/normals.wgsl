// The normal of every particle. A thread a texel.
@group(0) @binding(2) var<storage, read> now: array<vec4<f32>>;
@group(0) @binding(8) var<storage, read_write> normals: array<vec4<f32>>;

@compute @workgroup_size(16, 4)
fn main(@builtin(global_invocation_id) id: vec3<u32>) {
  let grid = grids[id.z];
  if (id.x >= grid.width || id.y >= grid.height) {
    return;
  }
  let k = grid.first + id.y * grid.width + id.x;
  normals[k] = normal_at(grid, id.x, id.y, k);
}
