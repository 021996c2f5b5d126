// The multiplier of bending at a texel: the Laplacian of position over what a step of this length makes of its compliance,
// or over the bound with which no step goes too far. w is 1 where there is one.

fn moment_at(grid: Grid, cell: vec2<u32>, k: u32) -> vec4<f32> {
  let bend = bends_at(k);
  var whole = bend.x > 0.0;
  var sum = vec3<f32>(0.0);
  if (whole) {
    let at = place(k).xyz;
    for (var n = 0u; n < 8u; n++) {
      let e = edge(grid, cell, n);
      if (e.weight != 0.0) {
        sum += (place(e.other).xyz - at) * e.weight;
        whole = whole && unbroken(e);
      }
    }
  }
  let scale = 1.0 / max(bend.x / (step.dt * step.dt), bend.y);
  return select(vec4<f32>(0.0), vec4<f32>(sum * scale, 1.0), whole);
}

fn moment(g: u32, cell: vec2<u32>, k: u32) {
  set_moments(k, moment_at(grids_at(g), cell, k));
}
