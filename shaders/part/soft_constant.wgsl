// All springs of a grid have one compliance.
fn compliance(grid: u32, k: u32, direction: u32) -> f32 {
  return grids_at(grid).soft;
}
