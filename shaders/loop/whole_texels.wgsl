// A rule of texels in a whole frame.
fn each_all(job: Job, local: u32) {
  for (var g = job.grid; g < job.grid + job.grids; g++) {
    let grid = grids_at(g);
    for (var n = local; n < grid.width * grid.height; n += threads) {
      each(g, vec2<u32>(n % grid.width, n / grid.width), grid.first + n);
    }
  }
}
