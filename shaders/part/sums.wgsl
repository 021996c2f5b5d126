// Multipliers where they lie.
fn summed(k: u32, direction: u32) -> f32 {
  return sums_at(k)[direction];
}

fn sum_up(k: u32, direction: u32, sum: f32) {
  put_sums(k, direction, sum);
}

fn end_sums(k: u32) {
  set_sums(k, vec4<f32>(0.0));
}
