// The eight neighbours of a particle, in cyclic order from the right by way of down; -1 where there is none.
fn neighbour(grid: Grid, i: u32, j: u32, n: u32) -> i32 {
  var steps = array<vec2<i32>, 8>(
    vec2<i32>(1, 0), vec2<i32>(1, 1), vec2<i32>(0, 1), vec2<i32>(-1, 1),
    vec2<i32>(-1, 0), vec2<i32>(-1, -1), vec2<i32>(0, -1), vec2<i32>(1, -1));
  let at = vec2<i32>(i32(i), i32(j)) + steps[n & 7u];
  if (at.x < 0 || at.y < 0 || at.x >= i32(grid.width) || at.y >= i32(grid.height)) {
    return -1;
  }
  let k = i32(grid.first) + at.y * i32(grid.width) + at.x;
  return select(-1, k, place(u32(k)).w >= 0.0);
}

// The other two corners of up to two triangles of a particle in one quadrant, counter-clockwise seen from the front:
// (x, y) and (z, w), -1 where there is none. A quad of four particles is split along (i, j)-(i+1, j+1); one of three is
// a triangle. Triangles that are cut away are left out.
fn triangles(grid: Grid, i: u32, j: u32, quadrant: u32) -> vec4<i32> {
  let p = neighbour(grid, i, j, 2u * quadrant);
  let q = neighbour(grid, i, j, 2u * quadrant + 1u);
  let r = neighbour(grid, i, j, 2u * quadrant + 2u);
  let full = u32(min(p, min(q, r)) >= 0);
  // Wraps only where there is no triangle.
  let column = i - u32(quadrant == 1u || quadrant == 2u);
  let row = j - u32(quadrant > 1u);
  let bits = removed(grid.first + row * grid.width + column);
  if (p >= 0 && r >= 0 && (quadrant % 2u == 1u || q < 0)) {
    let gone = ((bits >> (full * u32(quadrant == 1u))) & 1u) != 0u;
    return vec4<i32>(select(p, -1, gone), r, -1, -1);
  }
  if (q < 0) {
    return vec4<i32>(-1);
  }
  let first = p >= 0 && ((bits >> (full * u32(quadrant == 0u))) & 1u) == 0u;
  let second = r >= 0 && ((bits >> (full * u32(quadrant == 2u))) & 1u) == 0u;
  return vec4<i32>(select(-1, p, first), q, select(-1, q, second), r);
}
