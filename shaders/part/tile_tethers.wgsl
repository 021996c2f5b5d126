// Free particles are held back by their anchors.
fn hold(k: u32, p: vec4<f32>) -> vec4<f32> {
  if (p.w > 0.0) {
    return vec4<f32>(held_back(k, p.xyz), p.w);
  }
  return p;
}

fn hold_all(local: u32) {
  let columns = max(high.x - low.x, 1u);
  let by = by_rows(threads, columns);
  var cell = by_rows(local, columns);
  while (cell.y < high.y - low.y) {
    let at = low + cell;
    held[stored(at)] = hold(listed(at), held[stored(at)]);
    cell = on_by_rows(cell, by, columns);
  }
  workgroupBarrier();
}
