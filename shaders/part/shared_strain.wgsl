// The largest residual of the springs to the right and down of each cloth, as bits. A thread a texel.
@compute @workgroup_size(16, 4)
fn main(@builtin(global_invocation_id) id: vec3<u32>, @builtin(local_invocation_index) local: u32) {
  let g = member_grid(id.z);
  let grid = grids_at(g);
  var far = 0.0;
  if (has_grid(id.z) && id.x < grid.width && id.y < grid.height) {
    let k = grid.first + id.y * grid.width + id.x;
    if (id.x + 1u < grid.width) {
      far = residual(g, k, k + 1u, 0u);
    }
    if (id.y + 1u < grid.height) {
      far = larger(far, residual(g, k, k + grid.width, 1u));
    }
  }
  far = most(far, local);
  if (local == 0u) {
    atomicMax(&faults[fault(FAULT_STRAIN)], bitcast<u32>(far));
  }
}
