// The largest of 64 numbers that are not below 0.
const FAST = 3.0e38;

var<workgroup> shared_most: array<f32, 64>;

// What is no number or infinite counts as fast.
fn larger(a: f32, b: f32) -> f32 {
  return max(select(FAST, a, a < FAST), select(FAST, b, b < FAST));
}

fn most(mine: f32, local: u32) -> f32 {
  shared_most[local] = mine;
  workgroupBarrier();
  for (var half = 32u; half > 0u; half /= 2u) {
    if (local < half) {
      shared_most[local] = larger(shared_most[local], shared_most[local + half]);
    }
    workgroupBarrier();
  }
  return shared_most[0];
}
