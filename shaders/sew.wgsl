// A particle follows what its stitches pull with: those that end at it, one after the other.
fn sew(g: u32, cell: vec2<u32>, k: u32) {
  let p = place(k);
  var end = stitches_at(3u * k).z;
  var sum = vec3<f32>(0.0);
  for (var n = 0u; n < MOST_STITCHES && end != NO_STITCH; n++) {
    let owner = base + end / 8u;
    let number = end % 8u;
    let more = stitches_at(3u * owner + 1u);
    let share = select(shares_of(more)[number % 4u], -1.0, number == 4u);
    sum += pulls_at(owner).xyz * share;
    end = select(stitches_at(3u * owner + 2u)[number % 4u], more.w, number == 4u);
  }
  if (p.w > 0.0) {
    put(k, vec4<f32>(p.xyz + sum * p.w, p.w));
  }
}
