// A rule of workgroups as a pass of its own: one for all grids.
const threads: u32 = 256u;

@compute @workgroup_size(threads)
fn main(@builtin(workgroup_id) id: vec3<u32>, @builtin(local_invocation_index) local: u32) {
  let count = arrayLength(&grids);
  var most = 0u;
  for (var g = 0u; g < count; g++) {
    most = max(most, levels_at(g).y);
  }
  each(vec2<u32>(0u, count), id.xy, most, local);
}
