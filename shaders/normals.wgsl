// The normal of a particle from the triangles around it, weighed by area; w is the length of their sum.
fn normal_at(grid: Grid, i: u32, j: u32, k: u32) -> vec4<f32> {
  let p = place(k);
  var sum = vec3<f32>(0.0);
  if (p.w >= 0.0) {
    for (var quadrant = 0u; quadrant < 4u; quadrant++) {
      let t = triangles(grid, i, j, quadrant);
      if (t.x >= 0) {
        sum += cross(place(u32(t.x)).xyz - p.xyz, place(u32(t.y)).xyz - p.xyz);
      }
      if (t.z >= 0) {
        sum += cross(place(u32(t.z)).xyz - p.xyz, place(u32(t.w)).xyz - p.xyz);
      }
    }
  }
  return unit(sum);
}

fn normal(g: u32, cell: vec2<u32>, k: u32) {
  normals[k] = normal_at(grids_at(g), cell.x, cell.y, k);
}
