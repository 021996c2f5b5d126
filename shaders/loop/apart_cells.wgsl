// A rule of cells as a pass of its own: those of every other column and every other row have no particle in common.
override column: u32 = 0u;
override line: u32 = 0u;

@compute @workgroup_size(16, 4)
fn main(@builtin(global_invocation_id) id: vec3<u32>) {
  let grid = grids[id.z];
  let i = 2u * id.x + column;
  let j = 2u * id.y + line;
  if (i + 1u < grid.width && j + 1u < grid.height) {
    each(grid, i, j);
  }
}
