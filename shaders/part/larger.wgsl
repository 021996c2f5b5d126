// The larger of two numbers that are not below 0; NaN and infinity count as fast.
const FAST = 3.0e38;

fn larger(a: f32, b: f32) -> f32 {
  return max(select(FAST, a, a < FAST), select(FAST, b, b < FAST));
}
