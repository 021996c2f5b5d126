// A rule of workgroups in a whole frame: one has all grids of the cloth.
fn each_all(job: Job, local: u32) {
  each(vec2<u32>(job.grid, job.grid + job.grids), vec2<u32>(0u), job.levels, local);
}
