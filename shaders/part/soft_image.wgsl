// Compliance from an image: right, down, down-right, up-right.
fn compliance(grid: u32, k: u32, direction: u32) -> f32 {
  return soft_at(k)[direction];
}
