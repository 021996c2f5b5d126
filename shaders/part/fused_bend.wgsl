// Bending, once a step: the multiplier of every texel, then what particles make of it.
@group(0) @binding(27) var<storage, read_write> moments: array<vec4<f32>>;

fn bend_all(job: Job, local: u32) {
  for (var g = job.grid; g < job.grid + job.grids; g++) {
    let grid = grids[g];
    for (var n = local; n < grid.width * grid.height; n += threads) {
      let cell = vec2<u32>(n % grid.width, n / grid.width);
      moments[grid.first + n] = moment_at(grid, cell, grid.first + n);
    }
  }
  storageBarrier();
  join_moments_all(job, local);
  for (var g = job.grid; g < job.grid + job.grids; g++) {
    let grid = grids[g];
    for (var n = local; n < grid.width * grid.height; n += threads) {
      let k = grid.first + n;
      let p = place(k);
      if (p.w > 0.0) {
        put(k, bent(grid, vec2<u32>(n % grid.width, n / grid.width), k, p));
      }
    }
  }
  sync();
  seam_all(job, local);
}
