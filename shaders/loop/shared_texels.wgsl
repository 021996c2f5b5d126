// A rule of texels for several cloths: a thread a texel, a layer of workgroups a grid.
@compute @workgroup_size(16, 4)
fn main(@builtin(global_invocation_id) id: vec3<u32>) {
  let g = member_grid(id.z);
  let grid = grids_at(g);
  clear_faults(all(id.xy == vec2<u32>(0u)) && id.z % batch.y == 0u);
  if (has_grid(id.z) && id.x < grid.width && id.y < grid.height) {
    each(g, id.xy, grid.first + id.y * grid.width + id.x);
  }
}
