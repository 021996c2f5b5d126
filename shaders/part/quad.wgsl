// The triangles of a quad. Four particles: corners (i, j), (i, j + 1), (i + 1, j + 1) and (i, j), (i + 1, j + 1),
// (i + 1, j). Three: the one triangle that they make.
struct Quad {
  count: u32,
  first: vec3<u32>,
  second: vec3<u32>,
}

fn quad(grid: Grid, i: u32, j: u32) -> Quad {
  let none = vec3<u32>(0u);
  if (i + 1u >= grid.width || j + 1u >= grid.height) {
    return Quad(0u, none, none);
  }
  let k = grid.first + j * grid.width + i;
  let at = vec4<u32>(k, k + grid.width, k + grid.width + 1u, k + 1u);
  let w = vec4<f32>(now[at.x].w, now[at.y].w, now[at.z].w, now[at.w].w);
  let there = w >= vec4<f32>(0.0);
  if (all(there)) {
    return Quad(2u, at.xyz, at.xzw);
  }
  if (all(there.yzw)) {
    return Quad(1u, at.yzw, none);
  }
  if (all(there.xzw)) {
    return Quad(1u, at.xzw, none);
  }
  if (all(there.xyw)) {
    return Quad(1u, at.xyw, none);
  }
  if (all(there.xyz)) {
    return Quad(1u, at.xyz, none);
  }
  return Quad(0u, none, none);
}
