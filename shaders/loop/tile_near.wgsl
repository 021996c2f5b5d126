// A rule of particles that asks for the colliders near what a tile owns.
fn each_own(local: u32) {
  var least = vec3<f32>(3e38);
  var most = vec3<f32>(-3e38);
  let by = by_rows(threads, own_columns());
  var cell = by_rows(local, own_columns());
  while (cell.y < own_rows()) {
    let k = here(own_low + cell);
    let p = place(k);
    if (p.w > 0.0) {
      let earlier = was(k);
      least = min(least, min(p.xyz, earlier));
      most = max(most, max(p.xyz, earlier));
    }
    cell = on_by_rows(cell, by, own_columns());
  }
  gather(least, most, local, threads);
  cell = by_rows(local, own_columns());
  while (cell.y < own_rows()) {
    each(here(own_low + cell));
    cell = on_by_rows(cell, by, own_columns());
  }
}
