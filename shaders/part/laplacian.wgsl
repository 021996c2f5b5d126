// The eight springs around a texel with their weights in the Laplacian: right, left, down, up, down-right, up-left,
// up-right, down-left. A weight is stored as its spring's rest length is.

struct Edge {
  other: u32,
  stored: u32,
  direction: u32,
  weight: f32,
}

// Edge n of texel (i, j); its weight is 0 where there is none.
fn edge(grid: Grid, cell: vec2<u32>, n: u32) -> Edge {
  let direction = n / 2u;
  let back = n % 2u == 1u;
  let right = select(1, 0, direction == 1u);
  let down = select(select(1, -1, direction == 3u), 0, direction == 0u);
  let way = select(1, -1, back);
  let to = vec2<i32>(cell) + vec2<i32>(right, down) * way;
  let k = grid.first + cell.y * grid.width + cell.x;
  if (to.x < 0 || to.y < 0 || to.x >= i32(grid.width) || to.y >= i32(grid.height)) {
    return Edge(k, k, direction, 0.0);
  }
  let other = grid.first + u32(to.y) * grid.width + u32(to.x);
  let stored = select(k, other, back);
  return Edge(other, stored, direction, weights_at(stored)[direction]);
}
