// The nearest of 64 candidates: distance and code of a triangle as bits, which are ordered as the numbers are because
// no distance is below 0. Equal distances go to the lower code.
const NOTHING = vec4<u32>(0xffffffffu, 0xffffffffu, 0u, 0u);

var<workgroup> shared_best: array<vec4<u32>, 64>;

fn nearer(a: vec4<u32>, b: vec4<u32>) -> vec4<u32> {
  return select(b, a, a.x < b.x || (a.x == b.x && a.y <= b.y));
}

fn nearest(mine: vec4<u32>, local: u32) -> vec4<u32> {
  shared_best[local] = mine;
  workgroupBarrier();
  for (var half = 32u; half > 0u; half /= 2u) {
    if (local < half) {
      shared_best[local] = nearer(shared_best[local], shared_best[local + half]);
    }
    workgroupBarrier();
  }
  return shared_best[0];
}
