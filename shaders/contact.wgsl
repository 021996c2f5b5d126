// A particle inside a moving collider, or on its other side, goes to its surface, collider by collider.
fn clear(k: u32) {
  let p = place(k);
  if (p.w > 0.0) {
    put(k, vec4<f32>(cleared(p.xyz, was(k)), p.w));
  }
}
