// The pull of a stitch: the way to its length, over the sum of the inverse masses that it moves, each counted as often as stitches
// move it. So stitches that share a particle do not go too far together, and each moves its two sides by equal momentum.
fn stitch(g: u32, cell: vec2<u32>, k: u32) {
  let head = stitches_at(3u * k);
  if (head.x == NO_STITCH) {
    return;
  }
  let more = stitches_at(3u * k + 1u);
  let first = base + head.x;
  let share = shares_of(more);
  let p = place(k);
  let a = place(first);
  let b = place(first + 1u);
  let c = place(first + head.y);
  let d = place(first + head.y + 1u);
  let way = p.xyz - (a.xyz * share.x + b.xyz * share.y + c.xyz * share.z + d.xyz * share.w);
  let corners = vec4<f32>(count_of(head.w, 0u), count_of(head.w, 1u), count_of(head.w, 2u), count_of(head.w, 3u));
  let inverse = max(vec4<f32>(a.w, b.w, c.w, d.w), vec4<f32>(0.0));
  let weight = count_of(head.w, 4u) * max(p.w, 0.0) + dot(corners * share * share, inverse);
  let far = sqrt(dot(way, way));
  let by = (far - bitcast<f32>(more.z)) / (max(far, 1e-30) * max(weight, 1e-30));
  let holds = weight > 0.0 && removed(first) == 0u;
  set_pulls(k, select(vec4<f32>(0.0), vec4<f32>(way * by, 0.0), holds));
}
