// A particle follows the multipliers of bending: by the Laplacian of these, times the inverse mass.
fn bent(grid: Grid, cell: vec2<u32>, k: u32, p: vec4<f32>) -> vec4<f32> {
  let at = moments_at(k).xyz;
  var sum = vec3<f32>(0.0);
  for (var n = 0u; n < 8u; n++) {
    let e = edge(grid, cell, n);
    if (e.weight != 0.0) {
      sum += (moments_at(e.other).xyz - at) * e.weight;
    }
  }
  return vec4<f32>(p.xyz - sum * p.w, p.w);
}

fn bend(g: u32, cell: vec2<u32>, k: u32) {
  let p = place(k);
  if (p.w > 0.0) {
    put(k, bent(grids_at(g), cell, k, p));
  }
}
