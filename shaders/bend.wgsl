// Particles follow the multipliers of bending: by the Laplacian of these, times the inverse mass.
@group(0) @binding(2) var<storage, read_write> now: array<vec4<f32>>;
@group(0) @binding(27) var<storage, read> moments: array<vec4<f32>>;

@compute @workgroup_size(16, 4)
fn main(@builtin(global_invocation_id) id: vec3<u32>) {
  let grid = grids[id.z];
  if (id.x >= grid.width || id.y >= grid.height) {
    return;
  }
  let k = grid.first + id.y * grid.width + id.x;
  let p = now[k];
  if (p.w <= 0.0) {
    return;
  }
  let at = moments[k].xyz;
  var sum = vec3<f32>(0.0);
  for (var n = 0u; n < 8u; n++) {
    let e = edge(grid, id.xy, n);
    if (e.weight != 0.0) {
      sum += (moments[e.other].xyz - at) * e.weight;
    }
  }
  now[k] = vec4<f32>(p.xyz - sum * p.w, p.w);
}
