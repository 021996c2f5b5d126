// The largest of 64 numbers that are not below 0.
var<workgroup> shared_most: array<f32, 64>;

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
