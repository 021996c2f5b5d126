// A rule of springs for several cloths: springs of one direction and parity have no particle in common.
override direction: u32 = 0u;
override parity: u32 = 0u;

@compute @workgroup_size(16, 4)
fn main(@builtin(global_invocation_id) id: vec3<u32>) {
  let g = member_grid(id.z);
  let grid = grids_at(g);
  clear_faults(all(id.xy == vec2<u32>(0u)) && id.z % batch.y == 0u);
  let ends = spring_ends(id.xy, grid.first, vec2<u32>(grid.width, grid.height), direction, parity);
  if (has_grid(id.z) && ends.inside) {
    each(g, ends, direction);
  }
}
