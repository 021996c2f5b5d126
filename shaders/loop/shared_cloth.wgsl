// A rule of workgroups for several cloths: one a cloth.
const threads: u32 = 256u;

@compute @workgroup_size(threads)
fn main(@builtin(workgroup_id) id: vec3<u32>, @builtin(local_invocation_index) local: u32) {
  member(id.z);
  clear_faults(local == 0u);
  // Browsers refuse a barrier that depends on a private variable, so the job is read once more.
  let job = jobs_at(batch.x + id.z);
  each(vec2<u32>(job.grid, job.grid + job.grids), id.xy, job.levels, local);
}
