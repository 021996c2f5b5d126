// Residual of a spring: its stretch minus the share of its compliance. 0 where no spring exists, or where it
// cannot move.
fn residual(grid: u32, k: u32, other: u32, direction: u32) -> f32 {
  let a = now[k];
  let b = now[other];
  let rest = rest_length(grid, k, direction);
  let w = a.w + b.w;
  if (rest <= 0.0 || min(a.w, b.w) < 0.0 || w <= 0.0) {
    return 0.0;
  }
  let d = b.xyz - a.xyz;
  return max(sqrt(dot(d, d)) / rest - 1.0, 0.0) * share(grid, k, direction, w);
}
