// A pinned particle that follows joints is where the skin is at the end of the step. It keeps where it was, as a free one does.
fn follow(g: u32, cell: vec2<u32>, k: u32) {
  let p = place(k);
  if (p.w != 0.0 || drifts_at(k).w == 0.0) {
    return;
  }
  set_was(k, p);
  put(k, vec4<f32>(aim(k).xyz, 0.0));
}
