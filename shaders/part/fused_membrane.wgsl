// The four colours of a membrane, once a step.
fn membrane_all(job: Job, local: u32) {
  cells_all(job, local, 0u, 0u);
  cells_all(job, local, 1u, 0u);
  cells_all(job, local, 0u, 1u);
  cells_all(job, local, 1u, 1u);
}

// The cells of every other column and row.
fn cells_all(job: Job, local: u32, column: u32, row_parity: u32) {
  let yields = yielding[job.row].xyz;
  for (var g = job.grid; g < job.grid + job.grids; g++) {
    let grid = grids[g];
    let columns = grid.width / 2u;
    let stride = by_rows(threads, columns);
    var cell = by_rows(local, columns);
    while (cell.y < grid.height / 2u) {
      let i = 2u * cell.x + column;
      let j = 2u * cell.y + row_parity;
      if (i + 1u < grid.width && j + 1u < grid.height) {
        relax_cell(grid, i, j, yields);
      }
      cell += stride;
      if (cell.x >= columns) {
        cell = vec2<u32>(cell.x - columns, cell.y + 1u);
      }
    }
  }
  sync();
}
