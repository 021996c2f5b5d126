// Particles follow the nodes of the finest level; most of the way carries no velocity on.
@group(0) @binding(2) var<storage, read_write> now: array<vec4<f32>>;
@group(0) @binding(3) var<storage, read_write> before: array<vec4<f32>>;
@group(0) @binding(21) var<storage, read> nodes: array<vec4<f32>>;

// The share of a displacement that carries no velocity on.
override carried: f32 = 0.9;

@compute @workgroup_size(16, 4)
fn main(@builtin(global_invocation_id) id: vec3<u32>) {
  let grid = grids[id.z];
  let head = levels[id.z];
  if (id.x >= grid.width || id.y >= grid.height || head.width == 0u) {
    return;
  }
  let k = grid.first + id.y * grid.width + id.x;
  let p = now[k];
  if (p.w <= 0.0) {
    return;
  }
  let d = moved(levels[head.first], id.x, id.y, grid.width, grid.height, followed(k));
  let was = before[k];
  now[k] = vec4<f32>(p.xyz + d, p.w);
  before[k] = vec4<f32>(was.xyz + d * carried, was.w);
}
