// All duplicates of a seam point take their mean, or the position of the first pinned one.
fn close(ring: u32) {
  let at = meeting(ring);
  let end = starts_at(ring + 1u);
  for (var m = starts_at(ring); m < end; m++) {
    let k = members_at(m);
    put(k, vec4<f32>(at, place(k).w));
  }
}
