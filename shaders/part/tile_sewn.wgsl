// A tile that begins with seams and the passes after them: it makes both for all particles that it loads, so that it needs no result of
// other tiles.
// `sew_program` and `touch_program` are made from the list of passes: those before contact, and contact.
fn loose(k: u32) -> vec4<f32> {
  return now[k];
}

fn taken(k: u32) -> vec4<f32> {
  return place(k);
}

fn end_last_step(local: u32) {
  begin_tail();
  let columns = max(high.x - low.x, 1u);
  let by = by_rows(threads, columns);
  var cell = by_rows(local, columns);
  while (cell.y < high.y - low.y) {
    let k = here(low + cell);
    put(k, sewn(k));
    if (sewing) {
      sew_program(k);
    }
    cell = on_by_rows(cell, by, columns);
  }
  find_near(local);
  cell = by_rows(local, columns);
  while (cell.y < high.y - low.y) {
    let k = here(low + cell);
    if (sewing) {
      touch_program(k);
    }
    cell = on_by_rows(cell, by, columns);
  }
  begin(part.x, cloth);
}
