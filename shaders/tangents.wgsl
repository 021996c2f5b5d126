// Tangents: the direction in which u of the texture grows along the cloth, across the normal, and in w the side of it to
// which v grows.
@group(0) @binding(47) var<storage, read_write> tangents: array<vec4<f32>>;
@group(0) @binding(48) var<storage, read> charts: array<vec4<f32>>;

// The way from one neighbour in a line to the other, per texel. A neighbour that is not there, or behind a cut, does not
// count.
fn along(k: u32, by: u32, back: bool, on: bool) -> vec3<f32> {
  let behind = back && now[select(k, k - by, back)].w >= 0.0;
  let ahead = on && now[select(k, k + by, on)].w >= 0.0;
  let start = now[select(k, k - by, behind)].xyz;
  let end = now[select(k, k + by, ahead)].xyz;
  return (end - start) * select(1.0, 0.5, behind && ahead);
}

// Whether the edges of a texel to the right and down are gone: those at no triangle that is left.
fn gone(grid: Grid, i: i32, j: i32) -> vec2<bool> {
  let here = sides(grid, i, j).x;
  let left = sides(grid, i - 1, j).x;
  let above = sides(grid, i, j - 1).x;
  return vec2<bool>(((here & 2u) | (above & 1u)) == 0u, ((here & 1u) | (left & 2u)) == 0u);
}

fn tangent(g: u32, cell: vec2<u32>, k: u32) {
  tangents[k] = vec4<f32>(0.0);
  if (now[k].w < 0.0) {
    return;
  }
  let grid = grids[g];
  let i = i32(cell.x);
  let j = i32(cell.y);
  let here = gone(grid, i, j);
  let back = vec2<bool>(i > 0 && !gone(grid, i - 1, j).x, j > 0 && !gone(grid, i, j - 1).y);
  let row = along(k, 1u, back.x, cell.x + 1u < grid.width && !here.x);
  let column = along(k, grid.width, back.y, cell.y + 1u < grid.height && !here.y);
  let chart = charts[k];
  let n = normals[k].xyz;
  let t = row * chart.x + column * chart.y;
  tangents[k] = vec4<f32>(unit(t - n * dot(n, t)).xyz, chart.z);
}
