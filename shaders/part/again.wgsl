// Several relaxations per step: multipliers are summed.
fn multiplier(grid: u32, k: u32, direction: u32, far: f32, rest: f32, w: f32) -> f32 {
  let a = compliance(grid, k, direction) / (step.dt * step.dt);
  let sum = summed(k, direction);
  let g = (far - rest - a * sum) / max(far * (w + a), 1e-30);
  sum_up(k, direction, sum + g * far);
  return g;
}
