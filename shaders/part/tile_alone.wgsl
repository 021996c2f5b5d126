// Tiles of one cloth: a layer of workgroups a grid. Sets the grid, and returns its size.
fn take_grid(layer: u32, first: bool) -> vec2<u32> {
  grid = layer;
  let found = grids_at(grid);
  return vec2<u32>(found.width, found.height);
}
