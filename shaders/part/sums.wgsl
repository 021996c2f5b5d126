// Multipliers where they lie.
@group(0) @binding(18) var<storage, read_write> sums: array<vec4<f32>>;

fn summed(k: u32, direction: u32) -> f32 {
  return sums[k][direction];
}

fn sum_up(k: u32, direction: u32, sum: f32) {
  sums[k][direction] = sum;
}

fn end_sums(k: u32) {
  sums[k] = vec4<f32>(0.0);
}
