// Velocity of the air at a point: the wind, its heading turned by value noise.
fn lattice(cell: vec3<i32>) -> f32 {
  let c = bitcast<vec3<u32>>(cell) & vec3<u32>(1023u);
  var h = c.x | (c.y << 10u) | (c.z << 20u);
  // lowbias32 by C. Wellons: integer, so the same everywhere.
  h = (h ^ (h >> 16u)) * 0x7feb352du;
  h = (h ^ (h >> 15u)) * 0x846ca68bu;
  h = h ^ (h >> 16u);
  return f32(h >> 8u) * (1.0 / 8388608.0) - 1.0;
}

fn blend(a: f32, b: f32, t: f32) -> f32 {
  return a + (b - a) * t;
}

fn noise(q: vec3<f32>) -> f32 {
  let base = floor(q);
  let f = q - base;
  let u = f * f * (3.0 - 2.0 * f);
  let cell = vec3<i32>(base);
  var row: array<f32, 4>;
  for (var k = 0; k < 4; k++) {
    let at = cell + vec3<i32>(0, k & 1, k >> 1u);
    row[k] = blend(lattice(at), lattice(at + vec3<i32>(1, 0, 0)), u.x);
  }
  return blend(blend(row[0], row[1], u.y), blend(row[2], row[3], u.y), u.z);
}

fn air(p: vec3<f32>) -> vec3<f32> {
  let t = step.turn * noise(p * step.fineness - step.drift);
  // cos and sin by the tangent of the half angle: no trigonometry, so devices agree.
  let over = 1.0 / (1.0 + t * t);
  let c = (1.0 - t * t) * over;
  let s = 2.0 * t * over;
  let w = step.wind;
  return vec3<f32>(c * w.x + s * w.z, w.y, c * w.z - s * w.x);
}
