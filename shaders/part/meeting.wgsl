// Where all duplicates of a seam point meet: in their mean, or where the first pinned one is.
fn meeting(ring: u32) -> vec3<f32> {
  let first = starts_at(ring);
  let end = starts_at(ring + 1u);
  var sum = vec3<f32>(0.0);
  var pinned = false;
  for (var m = first; m < end && !pinned; m++) {
    let p = loose(members_at(m));
    pinned = p.w == 0.0;
    sum = select(sum + p.xyz, p.xyz, pinned);
  }
  return select(sum * (1.0 / f32(end - first)), sum, pinned);
}
