// One relaxation a step: no multiplier to go on from.
fn multiplier(grid: u32, k: u32, direction: u32, far: f32, rest: f32, w: f32) -> f32 {
  let a = compliance(grid, k, direction) / (step.dt * step.dt);
  return (far - rest) / max(far * (w + a), 1e-30);
}
