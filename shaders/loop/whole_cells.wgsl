// A rule of cells in a whole frame: those of every other column and row.
fn each_all(job: Job, local: u32, column: u32, line: u32) {
  for (var g = job.grid; g < job.grid + job.grids; g++) {
    let grid = grids_at(g);
    let columns = grid.width / 2u;
    let stride = by_rows(threads, columns);
    var cell = by_rows(local, columns);
    while (cell.y < grid.height / 2u) {
      let i = 2u * cell.x + column;
      let j = 2u * cell.y + line;
      if (i + 1u < grid.width && j + 1u < grid.height) {
        each(grid, i, j);
      }
      cell = on_by_rows(cell, stride, columns);
    }
  }
}
