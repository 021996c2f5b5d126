// A rule of springs in a tile, colour by colour. See crates/runtime/src/tile/reach.rs.

fn each_all(local: u32, direction: u32, parity: u32) {
  // Columns and rows of cells, as spring_ends has them.
  var x = vec2<u32>(low.x, max(high.x, 1u) - u32(direction != 1u));
  var y = vec2<u32>(low.y, high.y);
  if (direction == 0u) {
    x = pairs(low.x, high.x, parity);
  } else {
    y = pairs(low.y, high.y, parity);
  }
  let columns = max(x.y, x.x + 1u) - x.x;
  let rows = select(0u, max(y.y, y.x) - y.x, x.y > x.x);
  let by = by_rows(threads, columns);
  var cell = by_rows(local, columns);
  while (cell.y < rows) {
    let at = cell + vec2<u32>(x.x, y.x);
    let ends = spring_ends(at, grids_at(grid).first, size, direction, parity);
    to_row(select(2u * at.y + parity, at.y, direction == 0u));
    each(grid, ends, direction);
    cell = on_by_rows(cell, by, columns);
  }
  if (direction == 0u) {
    x = within(low.x, high.x, size.x, parity);
  } else {
    x = vec2<u32>(low.x, high.x);
    if (direction > 1u) {
      let more = u32(high.x < size.x);
      x = vec2<u32>(low.x + u32(low.x > 0u), max(high.x, more) - more);
    }
    y = within(low.y, high.y, size.y, parity);
    low.y = y.x;
    high.y = y.y;
  }
  low.x = x.x;
  high.x = x.y;
}
