// Coarser grids. Row g of `levels` is the head of grid g: the row of its finest level, how many levels there are, and where the ties and
// the nodes of its cloth begin.

// One level: its first node, columns and rows, and where its limits begin.
struct Level {
  first: u32,
  width: u32,
  height: u32,
  image: u32,
}

fn level_at(n: u32) -> Level {
  let row = levels_at(n);
  return Level(row.x, row.y, row.z, row.w);
}

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

// How far the nodes around column i and row j of the grid below have moved, in the mean of those that it follows: bits for
// the upper left, upper right, lower left and lower right one.
fn moved(level: Level, i: u32, j: u32, width: u32, height: u32, follows: u32) -> vec3<f32> {
  let x = nodes_around(i, width);
  let y = nodes_around(j, height);
  let upper_left = node_moved(level, x.x, y.x);
  let upper_right = node_moved(level, x.y, y.x);
  let lower_left = node_moved(level, x.x, y.y);
  let lower_right = node_moved(level, x.y, y.y);
  if (follows == 15u) {
    return 0.5 * (0.5 * (upper_left + lower_left) + 0.5 * (upper_right + lower_right));
  }
  var sum = select(vec3<f32>(0.0), upper_left, (follows & 1u) != 0u);
  sum = sum + select(vec3<f32>(0.0), upper_right, (follows & 2u) != 0u);
  sum = sum + select(vec3<f32>(0.0), lower_left, (follows & 4u) != 0u);
  sum = sum + select(vec3<f32>(0.0), lower_right, (follows & 8u) != 0u);
  return sum * (1.0 / f32(max(countOneBits(follows), 1u)));
}
