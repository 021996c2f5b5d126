// The share of a stretch that one relaxation takes away, and the next step brings back: the rest is what the spring yields.
fn share(grid: u32, k: u32, direction: u32, w: f32) -> f32 {
  let gives = compliance(grid, k, direction);
  let moves = w * step.dt * step.dt;
  return select(moves / (gives + moves), 1.0, gives <= 0.0);
}
