// Rest lengths that are the same all over a grid.
fn rest_length(grid: u32, k: u32, direction: u32) -> f32 {
  return grids_at(grid).rest[direction];
}
