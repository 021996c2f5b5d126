// A rule of springs in a whole frame: one of eight colours. Cells by rows, a thread every `threads`-th.
fn each_all(job: Job, local: u32, direction: u32, parity: u32) {
  for (var g = job.grid; g < job.grid + job.grids; g++) {
    let grid = grids_at(g);
    let size = vec2<u32>(grid.width, grid.height);
    let columns = select(size.x, size.x / 2u, direction == 0u);
    let rows = select(size.y / 2u, size.y, direction == 0u);
    let stride = by_rows(threads, columns);
    var cell = by_rows(local, columns);
    while (cell.y < rows) {
      let ends = spring_ends(cell, grid.first, size, direction, parity);
      if (ends.inside) {
        each(g, ends, direction);
      }
      cell = on_by_rows(cell, stride, columns);
    }
  }
}
