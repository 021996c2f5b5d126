// Pinned duplicates of a seam point are where the first of them is, whether or not another thread has put them there yet.
// `n` counts those of the cloth.
fn anchor(n: u32) -> vec4<f32> {
  let k = base + n;
  let p = loose(k);
  if (p.w == 0.0) {
    return sewn(k);
  }
  return p;
}
