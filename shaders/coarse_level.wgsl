// Lengths are limited on one of the coarser grids, by tiles: a workgroup has a part of its nodes in its memory, with so much around it
// that the nodes it owns come out as if one workgroup had all (shaders/pyramid.wgsl). Tiles begin at odd columns and rows, as eight
// colours of springs then reach five nodes far (crates/runtime/src/tile/reach.rs).
// `limits` are as in shaders/pyramid.wgsl.

override right: bool = true;
override down: bool = true;
override down_right: bool = true;
override up_right: bool = true;
// The level, from 1 for the finest.
override level: u32 = 1u;

// Nodes that a tile owns along a side, those around them, and all.
const AROUND: u32 = 5u;
const SIDE: u32 = NODE_TILE + 2u * AROUND;

var<workgroup> held: array<vec4<f32>, SIDE * SIDE>;

// Takes a node from the grid, and moves it with the level above.
fn gather_node(grid: Grid, here: Level, above: Level, top: bool, at: vec2<u32>, own: bool) -> vec4<f32> {
  let n = at.y * here.width + at.x;
  let column = min(at.x << level, grid.width - 1u);
  let row = min(at.y << level, grid.height - 1u);
  let p = place(grid.first + row * grid.width + column);
  let k = 2u * (here.first + n);
  let w = select(0.0, nodes[k + 1u].w, p.w > 0.0);
  if (own) {
    // Other tiles read the fourth component.
    nodes[k + 1u].x = p.x;
    nodes[k + 1u].y = p.y;
    nodes[k + 1u].z = p.z;
  }
  if (!top && w > 0.0) {
    return vec4<f32>(p.xyz + moved(above, at.x, at.y, here.width, here.height, followed_by_node(here.image + n)), w);
  }
  return vec4<f32>(p.xyz, w);
}

// Where a tile lies on its level: its first node, and the end of its nodes.
struct Window {
  low: vec2<u32>,
  high: vec2<u32>,
}

// A spring of a colour, by its number in the tile: ends that are too far apart are drawn together.
fn limit_spring(n: u32, here: Level, part: Window, direction: u32, parity: u32) {
  var at = part.low;
  if (direction == 0u) {
    at += vec2<u32>(((part.low.x ^ parity) & 1u) + 2u * (n % (SIDE / 2u)), n / (SIDE / 2u));
  } else {
    at += vec2<u32>(n % SIDE, ((part.low.y ^ parity) & 1u) + 2u * (n / SIDE));
  }
  let across = u32(direction != 1u);
  let below = u32(direction != 0u);
  if (at.x + across >= part.high.x || at.y + below >= part.high.y) {
    return;
  }
  let first = (at.y - part.low.y) * SIDE + at.x - part.low.x;
  let upward = direction == 3u;
  let end = select(first, first + SIDE, upward);
  let other = select(first + below * SIDE + across, first + 1u, upward);
  let longest = limits_at(here.image + (at.y + u32(upward)) * here.width + at.x)[direction];
  let a = held[end];
  let b = held[other];
  let d = b.xyz - a.xyz;
  let far = max(sqrt(dot(d, d)), 1e-9);
  let g = (far - longest) / max(far * (a.w + b.w), 1e-30);
  if (longest > 0.0 && g > 0.0) {
    held[end] = vec4<f32>(a.xyz + d * (g * a.w), a.w);
    held[other] = vec4<f32>(b.xyz - d * (g * b.w), b.w);
  }
}

// A tile of grid `mine.x`; of none where that is not below `mine.y`.
fn limit_tile(mine: vec2<u32>, tile: vec2<u32>, most: u32, local: u32) {
  let grid = grids_at(mine.x);
  let head = levels_at(mine.x);
  // A grid may have fewer levels.
  let there = mine.x < mine.y && level <= head.y;
  let here = level_at(head.x + select(0u, level - 1u, there));
  let top = level >= head.y;
  let above = level_at(head.x + select(level, 0u, top));
  let size = select(vec2<u32>(0u), vec2<u32>(here.width, here.height), there);
  let own_low = min(max(tile * NODE_TILE, vec2<u32>(1u)) - 1u, size);
  let own_high = min((tile + 1u) * NODE_TILE - 1u, size);
  let low = max(own_low, vec2<u32>(AROUND)) - AROUND;
  let part = Window(low, select(low, min(own_high + AROUND, size), all(own_low < own_high)));
  for (var n = local; n < SIDE * SIDE; n += threads) {
    let at = low + vec2<u32>(n % SIDE, n / SIDE);
    if (all(at < part.high)) {
      held[n] = gather_node(grid, here, above, top, at, all(at >= own_low) && all(at < own_high));
    }
  }
  workgroupBarrier();
  for (var c = 0u; c < 8u; c++) {
    // Diagonals first: what they disturb, the others put right.
    let direction = (c / 2u + 2u) % 4u;
    if (!(array<bool, 4>(right, down, down_right, up_right))[direction]) {
      continue;
    }
    for (var n = local; n < SIDE * SIDE / 2u; n += threads) {
      limit_spring(n, here, part, direction, c % 2u);
    }
    workgroupBarrier();
  }
  for (var n = local; n < SIDE * SIDE; n += threads) {
    let at = low + vec2<u32>(n % SIDE, n / SIDE);
    if (all(at >= own_low) && all(at < own_high)) {
      nodes[2u * (here.first + at.y * here.width + at.x)] = held[n];
    }
  }
}
