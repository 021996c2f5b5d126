// A rule of particles with their places in a whole frame. A thread has its particles in ascending order, and so their grids.
fn each_all(job: Job, local: u32) {
  var g = job.grid;
  var grid = grids_at(g);
  for (mine = 0u; has_more(job.count); mine++) {
    let k = job.first + local + mine * threads;
    if (k < job.first + job.count) {
      while (k >= grid.first + grid.width * grid.height) {
        g++;
        grid = grids_at(g);
      }
      let n = k - grid.first;
      each(g, vec2<u32>(n % grid.width, n / grid.width), k);
    }
  }
}
