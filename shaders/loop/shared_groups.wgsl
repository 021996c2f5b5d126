// A rule of workgroups for several cloths: one a grid, or a tile of a grid.
const threads: u32 = 256u;

@compute @workgroup_size(threads)
fn main(@builtin(workgroup_id) id: vec3<u32>, @builtin(local_invocation_index) local: u32) {
  let g = member_grid(id.z);
  clear_faults(local == 0u && all(id.xy == vec2<u32>(0u)) && id.z % batch.y == 0u);
  // Browsers refuse a barrier that depends on a private variable, so the job is read once more.
  let job = jobs_at(batch.x + id.z / batch.y);
  each(vec2<u32>(g, g + u32(has_grid(id.z))), id.xy, job.levels, local);
}
