// One of eight passes: springs with compliance, of one direction and parity, so that none has a particle in common.
@group(0) @binding(2) var<storage, read_write> now: array<vec4<f32>>;

override direction: u32 = 0u;
override parity: u32 = 0u;

@compute @workgroup_size(16, 4)
fn main(@builtin(global_invocation_id) id: vec3<u32>) {
  let grid = grids[id.z];
  let ends = spring_ends(id.xy, grid.first, vec2<u32>(grid.width, grid.height), direction, parity);
  if (!ends.inside) {
    return;
  }
  let k = ends.k;
  let other = ends.other;
  let rest = rest_length(id.z, k, direction);
  let a = now[k];
  let b = now[other];
  if (rest <= 0.0 || min(a.w, b.w) < 0.0) {
    return;
  }
  let d = b.xyz - a.xyz;
  let far = max(sqrt(dot(d, d)), 1e-9);
  let g = multiplier(id.z, k, direction, far, rest, a.w + b.w);
  now[k] = vec4<f32>(a.xyz + d * (g * a.w), a.w);
  now[other] = vec4<f32>(b.xyz - d * (g * b.w), b.w);
}
