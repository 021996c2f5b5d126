// A rule of texels as a pass of its own: a thread a texel.
@compute @workgroup_size(16, 4)
fn main(@builtin(global_invocation_id) id: vec3<u32>) {
  let grid = grids[id.z];
  if (id.x < grid.width && id.y < grid.height) {
    each(id.z, id.xy, grid.first + id.y * grid.width + id.x);
  }
}
