// The triangles of each quad, six indices per texel: those of quad.wgsl, and a point for each that is not there. A thread
// per texel.
@group(0) @binding(2) var<storage, read> now: array<vec4<f32>>;
@group(0) @binding(46) var<storage, read_write> indices: array<u32>;

fn put(at: u32, corners: vec3<u32>) {
  indices[at] = corners.x;
  indices[at + 1u] = corners.y;
  indices[at + 2u] = corners.z;
}

@compute @workgroup_size(16, 4)
fn main(@builtin(global_invocation_id) id: vec3<u32>) {
  let grid = grids[id.z];
  if (id.x >= grid.width || id.y >= grid.height) {
    return;
  }
  let k = grid.first + id.y * grid.width + id.x;
  let q = quad(grid, id.x, id.y);
  let bits = removed(k);
  let point = vec3<u32>(k);
  // The corners of a quad turn clockwise, seen from the side that normals point to.
  put(6u * k, select(point, q.first.xzy, q.count > 0u && (bits & 1u) == 0u));
  put(6u * k + 3u, select(point, q.second.xzy, q.count > 1u && (bits & 2u) == 0u));
}
