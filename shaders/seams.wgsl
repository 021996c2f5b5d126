// All duplicates of a seam point take their mean, or the position of the first pinned one.
fn close(ring: u32) {
  let first = starts_at(ring);
  let end = starts_at(ring + 1u);
  var sum = vec3<f32>(0.0);
  var pinned = false;
  for (var m = first; m < end && !pinned; m++) {
    let p = place(members_at(m));
    pinned = p.w == 0.0;
    sum = select(sum + p.xyz, p.xyz, pinned);
  }
  let at = select(sum * (1.0 / f32(end - first)), sum, pinned);
  for (var m = first; m < end; m++) {
    let k = members_at(m);
    put(k, vec4<f32>(at, place(k).w));
  }
}
