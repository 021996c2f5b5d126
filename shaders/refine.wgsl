// A particle follows the nodes of the finest level; most of the way carries no velocity on.
@group(0) @binding(21) var<storage, read> nodes: array<vec4<f32>>;

// The share of a displacement that carries no velocity on.
override carried: f32 = 0.9;

fn follow(g: u32, cell: vec2<u32>, k: u32) {
  let grid = grids[g];
  let head = levels[g];
  let p = now[k];
  if (p.w <= 0.0 || head.width == 0u) {
    return;
  }
  let d = moved(levels[head.first], cell.x, cell.y, grid.width, grid.height, followed(k));
  let earlier = before[k];
  now[k] = vec4<f32>(p.xyz + d, p.w);
  before[k] = vec4<f32>(earlier.xyz + d * carried, earlier.w);
}
