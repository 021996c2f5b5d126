// The largest residual of the springs to the right and down, as bits, which are ordered as numbers that are not below 0
// are. A thread a texel.
@group(0) @binding(2) var<storage, read> now: array<vec4<f32>>;
@group(0) @binding(33) var<storage, read_write> strain: array<atomic<u32>>;

@compute @workgroup_size(16, 4)
fn main(@builtin(global_invocation_id) id: vec3<u32>, @builtin(local_invocation_index) local: u32) {
  let grid = grids[id.z];
  var far = 0.0;
  if (id.x < grid.width && id.y < grid.height) {
    let k = grid.first + id.y * grid.width + id.x;
    if (id.x + 1u < grid.width) {
      far = residual(id.z, k, k + 1u, 0u);
    }
    if (id.y + 1u < grid.height) {
      far = larger(far, residual(id.z, k, k + grid.width, 1u));
    }
  }
  far = most(far, local);
  if (local == 0u) {
    atomicMax(&strain[0], bitcast<u32>(far));
  }
}
