// Corners of a cloth's triangles, six to a quad of its grid, an instance a grid. Nothing but the simulation's buffers.
@group(0) @binding(2) var<storage, read> now: array<vec4<f32>>;
@group(0) @binding(3) var<storage, read> before: array<vec4<f32>>;
@group(0) @binding(8) var<storage, read> normals: array<vec4<f32>>;

// The triangle below or above the diagonal of a quad, which is given from (i, j) by way of (i+1, j); see neighbours.wgsl.
// One that is not there is a single point.
fn triangle(quad: vec4<u32>, there: vec4<bool>, upper: bool) -> vec3<u32> {
  if (all(there)) {
    return select(quad.xzw, quad.xyz, upper);
  }
  if (!upper && all(there.yzw)) {
    return quad.yzw;
  }
  if (!upper && all(there.xzw)) {
    return quad.xzw;
  }
  if (!upper && all(there.xyw)) {
    return quad.xyw;
  }
  if (!upper && all(there.xyz)) {
    return quad.xyz;
  }
  return vec3<u32>(quad.x);
}

fn corner(vertex: u32, instance: u32) -> Corner {
  let grid = grids[instance];
  let quad = vertex / 6u;
  let across = grid.width - 1u;
  let k = grid.first + quad / across * grid.width + quad % across;
  let upper = vertex % 6u >= 3u;
  let around = vec4<u32>(k, k + 1u, k + grid.width + 1u, k + grid.width);
  let there = vec4<bool>(
    now[around.x].w >= 0.0, now[around.y].w >= 0.0, now[around.z].w >= 0.0, now[around.w].w >= 0.0);
  var t = triangle(around, there, upper);
  if (hole(k, u32(upper))) {
    t = vec3<u32>(k);
  }
  let c = t[vertex % 3u];
  let at = before[c].xyz + (now[c].xyz - before[c].xyz) * view.fraction;
  return Corner(at, normals[c].xyz, texture(t, vertex % 3u), view.front, vec4<f32>(view.back.xyz, 0.0));
}
