// A rule of cells for several cloths: those of every other column and every other row have no particle in common.
override column: u32 = 0u;
override line: u32 = 0u;

@compute @workgroup_size(16, 4)
fn main(@builtin(global_invocation_id) id: vec3<u32>) {
  let g = member_grid(id.z);
  let grid = grids_at(g);
  clear_faults(all(id.xy == vec2<u32>(0u)) && id.z % batch.y == 0u);
  let i = 2u * id.x + column;
  let j = 2u * id.y + line;
  if (has_grid(id.z) && i + 1u < grid.width && j + 1u < grid.height) {
    each(grid, i, j);
  }
}
