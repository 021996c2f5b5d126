// Tangents: the direction in which u of the texture grows along the cloth, across the normal, and in w the side of it to
// which v grows. A thread per texel.
@group(0) @binding(2) var<storage, read> now: array<vec4<f32>>;
@group(0) @binding(8) var<storage, read> normals: array<vec4<f32>>;
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

// Whether the edges of a texel to the right and down are gone: those whose triangles are all cut away.
fn gone(grid: Grid, i: u32, j: u32) -> vec2<bool> {
  let k = grid.first + j * grid.width + i;
  let bits = removed(k);
  let above = j == 0u || (removed(select(k, k - grid.width, j > 0u)) & 1u) != 0u;
  let left = i == 0u || (removed(select(k, k - 1u, i > 0u)) & 2u) != 0u;
  let below = j + 1u == grid.height || (bits & 2u) != 0u;
  let right = i + 1u == grid.width || (bits & 1u) != 0u;
  return vec2<bool>(above && below, left && right);
}

@compute @workgroup_size(16, 4)
fn main(@builtin(global_invocation_id) id: vec3<u32>) {
  let grid = grids[id.z];
  if (id.x >= grid.width || id.y >= grid.height) {
    return;
  }
  let k = grid.first + id.y * grid.width + id.x;
  var tangent = vec4<f32>(0.0);
  if (now[k].w >= 0.0) {
    let here = gone(grid, id.x, id.y);
    let back = vec2<bool>(
      id.x > 0u && !gone(grid, max(id.x, 1u) - 1u, id.y).x,
      id.y > 0u && !gone(grid, id.x, max(id.y, 1u) - 1u).y);
    let row = along(k, 1u, back.x, id.x + 1u < grid.width && !here.x);
    let column = along(k, grid.width, back.y, id.y + 1u < grid.height && !here.y);
    let chart = charts[k];
    let n = normals[k].xyz;
    let t = row * chart.x + column * chart.y;
    let across = t - n * dot(n, t);
    tangent = vec4<f32>(unit(across).xyz, chart.z);
  }
  tangents[k] = tangent;
}
