// Lengths are limited on coarser grids of the cloth, from the coarsest to the finest that one workgroup has. One workgroup a grid, or
// for all grids of a cloth with seams. Levels with more nodes follow in shaders/coarse_level.wgsl; in a whole frame one workgroup has all.
// `limits` are the longest distances to the nodes right, down, down-right and up-right; 0 means no limit.

override right: bool = true;
override down: bool = true;
override down_right: bool = true;
override up_right: bool = true;
// The finest level that is limited here, from 1 on.
override finest: u32 = 1u;

// Takes nodes from the grid, and moves them with the level above.
fn gather_nodes(local: u32, grid: Grid, level: Level, above: Level, top: bool, stride: u32) {
  for (var n = local; n < level.width * level.height; n += threads) {
    let i = n % level.width;
    let j = n / level.width;
    let column = min(i * stride, grid.width - 1u);
    let row = min(j * stride, grid.height - 1u);
    let p = place(grid.first + row * grid.width + column);
    let k = 2u * (level.first + n);
    let inverse_mass = nodes[k + 1u].w;
    let w = select(0.0, inverse_mass, p.w > 0.0);
    var at = p.xyz;
    if (!top && w > 0.0) {
      at = at + moved(above, i, j, level.width, level.height, followed_by_node(level.image + n));
    }
    nodes[k] = vec4<f32>(at, w);
    nodes[k + 1u] = vec4<f32>(p.xyz, inverse_mass);
  }
}

// One of eight colours; ends that are too far apart are drawn together.
fn limit_springs(local: u32, level: Level, direction: u32, parity: u32) {
  let columns = select(level.width, level.width / 2u, direction == 0u);
  let rows = select(level.height / 2u, level.height, direction == 0u);
  for (var n = local; n < columns * rows; n += threads) {
    let cell = vec2<u32>(n % columns, n / columns);
    let ends = spring_ends(cell, level.first, vec2<u32>(level.width, level.height), direction, parity);
    if (!ends.inside) {
      continue;
    }
    let k = ends.k;
    let other = ends.other;
    let longest = limits_at(level.image + k - level.first)[direction];
    let a = nodes[2u * k];
    let b = nodes[2u * other];
    let d = b.xyz - a.xyz;
    let far = max(sqrt(dot(d, d)), 1e-9);
    let g = (far - longest) / max(far * (a.w + b.w), 1e-30);
    if (longest > 0.0 && g > 0.0) {
      nodes[2u * k] = vec4<f32>(a.xyz + d * (g * a.w), a.w);
      nodes[2u * other] = vec4<f32>(b.xyz - d * (g * b.w), b.w);
    }
  }
}

// The levels of the grids from `mine.x` up to, not including, `mine.y`, of which none has more than `most`.
fn limit_levels(mine: vec2<u32>, tile: vec2<u32>, most: u32, local: u32) {
  for (var n = most; n >= finest; n--) {
    for (var g = mine.x; g < mine.y; g++) {
      let head = levels_at(g);
      if (n <= head.y) {
        let top = n == head.y;
        let above = level_at(head.x + select(n, n - 1u, top));
        gather_nodes(local, grids_at(g), level_at(head.x + n - 1u), above, top, 1u << n);
      }
    }
    storageBarrier();
    for (var c = 0u; c < 8u; c++) {
      // Diagonals first: what they disturb, the others put right.
      let direction = (c / 2u + 2u) % 4u;
      if (!(array<bool, 4>(right, down, down_right, up_right))[direction]) {
        continue;
      }
      for (var g = mine.x; g < mine.y; g++) {
        let head = levels_at(g);
        if (n <= head.y) {
          limit_springs(local, level_at(head.x + n - 1u), direction, c % 2u);
        }
      }
      storageBarrier();
    }
    tie(levels_at(mine.x), local, n);
  }
}
