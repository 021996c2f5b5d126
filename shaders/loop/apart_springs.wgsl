// A rule of springs as a pass of its own: springs of one direction and parity have no particle in common.
override direction: u32 = 0u;
override parity: u32 = 0u;

@compute @workgroup_size(16, 4)
fn main(@builtin(global_invocation_id) id: vec3<u32>) {
  let grid = grids[id.z];
  let ends = spring_ends(id.xy, grid.first, vec2<u32>(grid.width, grid.height), direction, parity);
  if (ends.inside) {
    each(id.z, ends, direction);
  }
}
