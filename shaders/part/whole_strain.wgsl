// The largest residual of the springs to the right and down, as bits.
fn strain_all(job: Job, local: u32) {
  var far = 0.0;
  for (var g = job.grid; g < job.grid + job.grids; g++) {
    let grid = grids_at(g);
    for (var n = local; n < grid.width * grid.height; n += threads) {
      let k = grid.first + n;
      if (n % grid.width + 1u < grid.width) {
        far = larger(far, residual(g, k, k + 1u, 0u));
      }
      if (n + grid.width < grid.width * grid.height) {
        far = larger(far, residual(g, k, k + grid.width, 1u));
      }
    }
  }
  far = most_of_all(far, local);
  if (local == 0u) {
    atomicMax(&faults[FAULT_STRIDE * row + FAULT_STRAIN], bitcast<u32>(far));
  }
}
