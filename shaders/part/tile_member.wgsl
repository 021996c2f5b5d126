// Tiles of several cloths: a layer of workgroups for each grid of each. Sets the grid, and returns its size, which is 0 where there is none.
fn take_grid(layer: u32, first: bool) -> vec2<u32> {
  grid = member_grid(layer);
  clear_faults(first && layer % batch.y == 0u);
  let found = grids_at(grid);
  return select(vec2<u32>(0u), vec2<u32>(found.width, found.height), has_grid(layer));
}
