// Rest lengths from an image: right, down, down-right, up-right.
fn rest_length(grid: u32, k: u32, direction: u32) -> f32 {
  return rest_at(k)[direction];
}
