// The triangles of each quad, six indices per texel: those of quad.wgsl, and a point for each that is not there.
@group(0) @binding(46) var<storage, read_write> indices: array<u32>;

fn write(at: u32, corners: vec3<u32>) {
  indices[at] = corners.x;
  indices[at + 1u] = corners.y;
  indices[at + 2u] = corners.z;
}

fn index(g: u32, cell: vec2<u32>, k: u32) {
  let q = quad(grids[g], cell.x, cell.y);
  let bits = removed(k);
  let point = vec3<u32>(k);
  // The corners of a quad turn clockwise, seen from the side that normals point to.
  write(6u * k, select(point, q.first.xzy, q.count > 0u && (bits & 1u) == 0u));
  write(6u * k + 3u, select(point, q.second.xzy, q.count > 1u && (bits & 2u) == 0u));
}
