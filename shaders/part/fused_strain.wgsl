// The largest square of length / rest length of the springs to the right and down, as bits.
fn strain_all(job: Job, local: u32) {
  var far = 0.0;
  for (var g = job.grid; g < job.grid + job.grids; g++) {
    let grid = grids[g];
    for (var n = local; n < grid.width * grid.height; n += threads) {
      let k = grid.first + n;
      if (n % grid.width + 1u < grid.width) {
        far = larger(far, squared_ratio(now[k], now[k + 1u], rest_length(g, k, 0u)));
      }
      if (n + grid.width < grid.width * grid.height) {
        far = larger(far, squared_ratio(now[k], now[k + grid.width], rest_length(g, k, 1u)));
      }
    }
  }
  atomicMax(&faults[64u * row + 5u], bitcast<u32>(far));
}
