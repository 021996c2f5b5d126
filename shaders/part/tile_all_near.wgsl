// Finds the colliders near all that a tile has.
fn find_near(local: u32) {
  var least = vec3<f32>(3e38);
  var most = vec3<f32>(-3e38);
  let columns = max(high.x - low.x, 1u);
  let by = by_rows(threads, columns);
  var cell = by_rows(local, columns);
  while (cell.y < high.y - low.y) {
    let k = here(low + cell);
    let p = place(k);
    if (p.w > 0.0) {
      let earlier = was(k);
      least = min(least, min(p.xyz, earlier));
      most = max(most, max(p.xyz, earlier));
    }
    cell = on_by_rows(cell, by, columns);
  }
  gather(least, most, local, threads);
}
