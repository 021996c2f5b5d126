// One of eight passes: springs of one direction and parity have no particle in common, so ends are moved in place.
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
  let length = rest_length(id.z, k, direction);
  let a = now[k];
  let b = now[other];
  let sum = a.w + b.w;
  if (length <= 0.0 || min(a.w, b.w) < 0.0 || sum <= 0.0) {
    return;
  }
  let d = b.xyz - a.xyz;
  let far = max(sqrt(dot(d, d)), 1e-9);
  let by = d * (1.0 - length / far);
  now[k] = vec4<f32>(a.xyz + by * (a.w / sum), a.w);
  now[other] = vec4<f32>(b.xyz - by * (b.w / sum), b.w);
}
