// Normals of every grid, then one for the duplicates of a seam point.
@group(0) @binding(8) var<storage, read_write> normals: array<vec4<f32>>;

fn normal_all(job: Job, local: u32) {
  for (var g = job.grid; g < job.grid + job.grids; g++) {
    let grid = grids[g];
    for (var n = local; n < grid.width * grid.height; n += threads) {
      normals[grid.first + n] = normal_at(grid, n % grid.width, n / grid.width, grid.first + n);
    }
  }
  join_all(job, local);
}
