// A particle leaves the colliders.
fn clear_of(k: u32, p: vec4<f32>) -> vec4<f32> {
  if (p.w > 0.0) {
    return vec4<f32>(cleared(p.xyz, previous(k)), p.w);
  }
  return p;
}
