// Which colliders are near what the tile owns.
fn gather_all(local: u32, owned: vec2<u32>, columns: u32) {
  var least = vec3<f32>(3e38);
  var most = vec3<f32>(-3e38);
  let by = by_rows(threads, columns);
  var cell = by_rows(local, columns);
  while (cell.y < owned.y) {
    let at = own_low + cell;
    let p = held[stored(at)];
    if (p.w > 0.0) {
      let earlier = previous(listed(at));
      least = min(least, min(p.xyz, earlier));
      most = max(most, max(p.xyz, earlier));
    }
    cell = on_by_rows(cell, by, columns);
  }
  gather(least, most, local, threads);
}
