// Springs as stiff as the step allows.
fn multiplier(grid: u32, k: u32, direction: u32, far: f32, rest: f32, w: f32) -> f32 {
  return (far - rest) / max(far * w, 1e-30);
}
