// Coarser grids. For grid g `levels[g]` has the index of its finest level and, as width, how many there are.
struct Level {
  first: u32,
  width: u32,
  height: u32,
  unused: u32,
}
@group(0) @binding(20) var<storage, read> levels: array<Level>;

// The nodes between which column (or row) k of `size` lies; twice the same where it is on one.
fn nodes_around(k: u32, size: u32) -> vec2<u32> {
  if (k % 2u == 0u) {
    return vec2<u32>(k / 2u, k / 2u);
  }
  if (k + 1u == size) {
    return vec2<u32>(size / 2u, size / 2u);
  }
  return vec2<u32>(k / 2u, k / 2u + 1u);
}

// How far a node has moved. Each is two entries: where it is now, and where it was.
fn node_moved(level: Level, i: u32, j: u32) -> vec3<f32> {
  let k = 2u * (level.first + j * level.width + i);
  return nodes[k].xyz - nodes[k + 1u].xyz;
}

// How far the nodes around column i and row j of the grid below have moved, in the mean.
fn moved(level: Level, i: u32, j: u32, width: u32, height: u32) -> vec3<f32> {
  let x = nodes_around(i, width);
  let y = nodes_around(j, height);
  let left = 0.5 * (node_moved(level, x.x, y.x) + node_moved(level, x.x, y.y));
  let right = 0.5 * (node_moved(level, x.y, y.x) + node_moved(level, x.y, y.y));
  return 0.5 * (left + right);
}
