// A particle follows the nodes of the finest level; most of the way carries no velocity on.

// The share of a displacement that carries no velocity on.
override carried: f32 = 0.9;

fn refine(g: u32, cell: vec2<u32>, k: u32) {
  let grid = grids_at(g);
  let head = levels_at(g);
  let p = place(k);
  if (p.w <= 0.0 || head.y == 0u) {
    return;
  }
  let d = moved(level_at(head.x), cell.x, cell.y, grid.width, grid.height, followed(k));
  let earlier = was(k);
  put(k, vec4<f32>(p.xyz + d, p.w));
  set_was(k, vec4<f32>(earlier + d * carried, p.w));
}
