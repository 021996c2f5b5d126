// The triangles of a quad that are left (x) and that are cut away (y), as bits: 1 at its left and lower edges, 2 at its
// upper and right ones. The one triangle of a quad of three particles counts as both.
fn sides(grid: Grid, i: i32, j: i32) -> vec2<u32> {
  if (i < 0 || j < 0) {
    return vec2<u32>(0u);
  }
  let q = quad(grid, u32(i), u32(j));
  if (q.count == 0u) {
    return vec2<u32>(0u);
  }
  let bits = removed(grid.first + u32(j) * grid.width + u32(i));
  let away = select(bits, 3u, q.count == 1u && bits != 0u);
  return vec2<u32>(3u & ~away, away);
}
