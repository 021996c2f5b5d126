// The larger of two numbers that are not below 0; NaN and infinity count as fast. By their bits, as in `sane`.
const FAST: f32 = 3.0e38;

fn bounded(a: f32) -> u32 {
  return min(bitcast<u32>(a) & 0x7fffffffu, bitcast<u32>(FAST));
}

fn larger(a: f32, b: f32) -> f32 {
  return bitcast<f32>(max(bounded(a), bounded(b)));
}
