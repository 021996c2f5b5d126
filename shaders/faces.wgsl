// The features of each cell, by its upper left texel. Corners are counted around a cell from the upper left one downwards. Bits 0 and 1: its
// triangles; 2 to 5 and 6 to 9: their corners; 10 to 15: edges that it owns, four around it from the one between corners 0 and 1, then the two
// across; 16 to 19: vertices that it owns. Every feature belongs to one cell of its grid.
@group(0) @binding(2) var<storage, read> now: array<vec4<f32>>;
@group(0) @binding(67) var<storage, read> kin: array<u32>;
@group(0) @binding(90) var<storage, read_write> faces: array<u32>;

fn share(points: vec4<u32>, corners: u32, a: u32, b: u32) -> bool {
  return ((corners >> a) & (corners >> b) & 1u) == 1u && points[a] == points[b];
}

// The corners of a triangle, none if two are one point: its edges are those of neighbours.
fn drawn(points: vec4<u32>, corners: u32) -> u32 {
  let beside = share(points, corners, 0u, 1u) || share(points, corners, 1u, 2u) || share(points, corners, 2u, 3u);
  let across = share(points, corners, 3u, 0u) || share(points, corners, 0u, 2u) || share(points, corners, 1u, 3u);
  return select(corners, 0u, beside || across);
}

// The corners of both triangles of a cell, 0 for none.
fn triangles_of(grid: Grid, i: i32, j: i32) -> vec2<u32> {
  if (i < 0 || j < 0 || i + 1 >= i32(grid.width) || j + 1 >= i32(grid.height)) {
    return vec2<u32>(0u);
  }
  let k = grid.first + u32(j) * grid.width + u32(i);
  let at = vec4<u32>(k, k + grid.width, k + grid.width + 1u, k + 1u);
  let there = vec4<f32>(now[at.x].w, now[at.y].w, now[at.z].w, now[at.w].w) >= vec4<f32>(0.0);
  let corners = dot(select(vec4<u32>(0u), vec4<u32>(1u, 2u, 4u, 8u), there), vec4<u32>(1u));
  var both = vec2<u32>(select(0u, corners, countOneBits(corners) == 3u), 0u);
  if (corners == 15u) {
    both = vec2<u32>(7u, 13u);
  }
  let gone = removed(k);
  let begin = kin[3];
  let points = vec4<u32>(kin[begin + at.x], kin[begin + at.y], kin[begin + at.z], kin[begin + at.w]);
  let first = select(drawn(points, both.x), 0u, (gone & 1u) != 0u);
  let second = select(drawn(points, both.y), 0u, (gone & 2u) != 0u);
  return vec2<u32>(first, second);
}

// Whether a triangle of two has some corners.
fn has(triangles: vec2<u32>, corners: u32) -> bool {
  return (triangles.x & corners) == corners || (triangles.y & corners) == corners;
}

@compute @workgroup_size(16, 4)
fn main(@builtin(global_invocation_id) id: vec3<u32>) {
  let grid = grids[id.z];
  if (id.x >= grid.width || id.y >= grid.height) {
    return;
  }
  let i = i32(id.x);
  let j = i32(id.y);
  let own = triangles_of(grid, i, j);
  let left = triangles_of(grid, i - 1, j);
  let above = triangles_of(grid, i, j - 1);
  let corner = triangles_of(grid, i - 1, j - 1);
  let below = triangles_of(grid, i - 1, j + 1);
  var bits = select(0u, 1u, own.x > 0u) | select(0u, 2u, own.y > 0u) | (own.x << 2u) | (own.y << 6u);
  // Features to the left and above belong to the cell there, if it has them.
  bits |= select(0u, 1u << 10u, has(own, 3u) && !has(left, 12u));
  bits |= select(0u, 1u << 11u, has(own, 6u));
  bits |= select(0u, 1u << 12u, has(own, 12u));
  bits |= select(0u, 1u << 13u, has(own, 9u) && !has(above, 6u));
  bits |= select(0u, 1u << 14u, has(own, 5u));
  bits |= select(0u, 1u << 15u, has(own, 10u));
  bits |= select(0u, 1u << 16u, has(own, 1u) && !has(corner, 4u) && !has(left, 8u) && !has(above, 2u));
  bits |= select(0u, 1u << 17u, has(own, 2u) && !has(left, 4u) && !has(below, 8u));
  bits |= select(0u, 1u << 18u, has(own, 4u));
  bits |= select(0u, 1u << 19u, has(own, 8u) && !has(above, 4u));
  faces[grid.first + id.y * grid.width + id.x] = bits;
}
