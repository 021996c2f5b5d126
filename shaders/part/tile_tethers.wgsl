// Free particles are held back by their anchors.
fn hold(k: u32, p: vec4<f32>) -> vec4<f32> {
  if (p.w > 0.0) {
    return vec4<f32>(held_back(k, p.xyz), p.w);
  }
  return p;
}

fn hold_all(local: u32) {
  // A tile past the end of its grid has nothing: its springs have left a high end below the low one.
  let columns = max(high.x, low.x + 1u) - low.x;
  let rows = select(0u, max(high.y, low.y) - low.y, high.x > low.x);
  let by = by_rows(threads, columns);
  var cell = by_rows(local, columns);
  while (cell.y < rows) {
    let at = low + cell;
    held[stored(at)] = hold(listed(at), held[stored(at)]);
    cell = on_by_rows(cell, by, columns);
  }
  workgroupBarrier();
}
