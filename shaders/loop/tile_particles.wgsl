// A rule of particles in a tile: of all that are right so far, or of those that the tile owns.
fn each_all(local: u32) {
  // A tile past the end of its grid has nothing: its springs have left a high end below the low one.
  let columns = max(high.x, low.x + 1u) - low.x;
  let rows = select(0u, max(high.y, low.y) - low.y, high.x > low.x);
  let by = by_rows(threads, columns);
  var cell = by_rows(local, columns);
  while (cell.y < rows) {
    each(here(low + cell));
    cell = on_by_rows(cell, by, columns);
  }
}

fn each_own(local: u32) {
  let by = by_rows(threads, own_columns());
  var cell = by_rows(local, own_columns());
  while (cell.y < own_rows()) {
    each(here(own_low + cell));
    cell = on_by_rows(cell, by, own_columns());
  }
}
