// A rule of workgroups as a pass of its own: one a grid, or a tile of a grid.
const threads: u32 = 256u;

@compute @workgroup_size(threads)
fn main(@builtin(workgroup_id) id: vec3<u32>, @builtin(local_invocation_index) local: u32) {
  each(vec2<u32>(id.z, id.z + 1u), id.xy, levels_at(id.z).y, local);
}
