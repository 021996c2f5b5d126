// The duplicates of a seam point take their mean, or the position of the first pinned one, in positions and in previous
// positions: coarser grids move both.
fn close_steps(ring: u32) {
  let first = starts_at(ring);
  let end = starts_at(ring + 1u);
  var at = vec3<f32>(0.0);
  var earlier = vec3<f32>(0.0);
  var pinned = false;
  for (var m = first; m < end && !pinned; m++) {
    let p = place(members_at(m));
    let b = was(members_at(m));
    pinned = p.w == 0.0;
    at = select(at + p.xyz, p.xyz, pinned);
    earlier = select(earlier + b, b, pinned);
  }
  let share = select(1.0 / f32(end - first), 1.0, pinned);
  for (var m = first; m < end; m++) {
    let k = members_at(m);
    let w = place(k).w;
    put(k, vec4<f32>(at * share, w));
    set_was(k, vec4<f32>(earlier * share, w));
  }
}
