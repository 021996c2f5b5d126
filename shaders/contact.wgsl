// A particle inside a moving collider, or on its other side, goes to its surface, collider by collider. One that is nowhere stays there, so
// that the frame is taken back: a collider may seem to be on its way.
fn clear(k: u32) {
  let p = place(k);
  if (p.w > 0.0 && sane(p)) {
    put(k, vec4<f32>(cleared(p.xyz, was(k)), p.w));
  }
}
