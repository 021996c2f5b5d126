// Springs as stiff as the step allows; but what a diagonal one does has a bound, so that cloth may fold along it where folds
// cross. Cloth without a bound gets one so large that nothing reaches it, and the same shader. It is the bound of the steps that
// are made. See crates/runtime/src/cpu/fabric/stretch.rs.

fn multiplier(grid: u32, k: u32, direction: u32, far: f32, rest: f32, w: f32) -> f32 {
  var over = far - rest;
  if (direction >= 2u) {
    let bound = rest * grids_at(grid).soft;
    over = clamp(over, -bound, max(bound, over - rest * TORN));
  }
  return over / max(far * w, 1e-30);
}
