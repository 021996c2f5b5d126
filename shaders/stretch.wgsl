// A spring with compliance draws its ends together, or apart.
fn stretch(grid: u32, ends: Ends, direction: u32) {
  let k = ends.k;
  let other = ends.other;
  let rest = rest_length(grid, k, direction);
  let a = place(k);
  let b = place(other);
  if (rest <= 0.0 || min(a.w, b.w) < 0.0) {
    return;
  }
  var d = b.xyz - a.xyz;
  var far = max(sqrt(dot(d, d)), 1e-9);
  if (direction == 0u && far < rest * SHORT) {
    d += way(k - grids[grid].first) * (rest * ASIDE);
    far = max(sqrt(dot(d, d)), 1e-9);
  }
  let g = multiplier(grid, k, direction, far, rest, a.w + b.w);
  put(k, vec4<f32>(a.xyz + d * (g * a.w), a.w));
  put(other, vec4<f32>(b.xyz - d * (g * b.w), b.w));
}
