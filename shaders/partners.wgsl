// For each particle the nearest others that it may meet before the next search, the nearest first: MAX_PARTNERS pairs of an index, all ones
// for none, and the distance to keep. One thread per particle goes down the boxes of all grids.
@group(0) @binding(2) var<storage, read> now: array<vec4<f32>>;
@group(0) @binding(67) var<storage, read> kin: array<u32>;
@group(0) @binding(68) var<storage, read> homes: array<vec4<f32>>;
@group(0) @binding(69) var<storage, read> boxes: array<vec4<f32>>;
@group(0) @binding(70) var<storage, read_write> partners: array<vec2<u32>>;

const NOBODY: u32 = 0xffffffffu;

// The particle that searches.
struct Seeker {
  k: u32,
  grid: u32,
  cell: vec2<u32>,
  at: vec3<f32>,
  home: vec3<f32>,
  reach: f32,
  low: vec3<f32>,
  high: vec3<f32>,
}

// The nearest so far, the nearest first; of those equally far the one with the lower index.
var<private> count: u32 = 0u;
var<private> far: array<f32, MAX_PARTNERS>;
var<private> who: array<u32, MAX_PARTNERS>;
var<private> keep: array<f32, MAX_PARTNERS>;

fn take(apart: f32, other: u32, least: f32) {
  let last = MAX_PARTNERS - 1u;
  if (count > last && (far[last] < apart || (far[last] == apart && who[last] < other))) {
    return;
  }
  count = min(count + 1u, MAX_PARTNERS);
  var at = count - 1u;
  while (at > 0u && (far[at - 1u] > apart || (far[at - 1u] == apart && who[at - 1u] > other))) {
    far[at] = far[at - 1u];
    who[at] = who[at - 1u];
    keep[at] = keep[at - 1u];
    at -= 1u;
  }
  far[at] = apart;
  who[at] = other;
  keep[at] = least;
}

// Takes in the particles of a tile.
fn meet(own: Seeker, g: u32, tile: vec2<u32>, node: u32) {
  let grid = grids[g];
  let distance = bitcast<f32>(kin[0]);
  let reach = own.reach + boxes[2u * node].w;
  for (var n = 0u; n < 16u; n++) {
    let cell = 4u * tile + vec2<u32>(n % 4u, n / 4u);
    if (cell.x < grid.width && cell.y < grid.height) {
      let m = grid.first + cell.y * grid.width + cell.x;
      let q = now[m];
      let way = q.xyz - own.at;
      let apart = dot(way, way);
      // Of the duplicates of a point the first stands for all.
      if (apart < (distance + reach) * (distance + reach) && q.w >= 0.0 && kin[kin[3] + m] == m) {
        let beside = abs(vec2<i32>(cell) - vec2<i32>(own.cell));
        let close = g == own.grid && u32(max(beside.x, beside.y)) <= SKIPPED_CELLS;
        if (!close && !is_kin(own.k, m)) {
          let rest = homes[m].xyz - own.home;
          let least = min(distance, sqrt(dot(rest, rest)) * REST_SHARE);
          if (sqrt(apart) < least + reach) {
            take(apart, m, least);
          }
        }
      }
    }
  }
}

// Goes through the boxes of a grid that meet that of the particle, depth first: four boxes below each, the last of which leads back up.
fn search(own: Seeker, g: u32) {
  let table = kin[kin[2] + 2u * g];
  let top = kin[kin[2] + 2u * g + 1u] - 1u;
  var level = top;
  var cell = vec2<u32>(0u);
  var going = true;
  while (going) {
    let row = table + 3u * level;
    let sides = vec2<u32>(kin[row + 1u], kin[row + 2u]);
    var down = false;
    if (all(cell < sides)) {
      let node = kin[row] + cell.y * sides.x + cell.x;
      let inside = all(boxes[2u * node].xyz <= own.high) && all(own.low <= boxes[2u * node + 1u].xyz);
      down = inside && level > 0u;
      if (inside && level == 0u) {
        meet(own, g, cell, node);
      }
    }
    if (down) {
      level -= 1u;
      cell = 2u * cell;
    } else {
      while (level < top && (cell.x & cell.y & 1u) == 1u) {
        level += 1u;
        cell = cell / 2u;
      }
      going = level < top;
      cell = select(vec2<u32>(cell.x + 1u, cell.y), vec2<u32>(cell.x - 1u, cell.y + 1u), (cell.x & 1u) == 1u);
    }
  }
}

// Finds the grid of a particle, and all that does not change in the search.
fn seeker(k: u32, p: vec4<f32>) -> Seeker {
  var own: Seeker;
  own.k = k;
  for (var g = 0u; g < arrayLength(&grids); g++) {
    if (k >= grids[g].first) {
      own.grid = g;
    }
  }
  let grid = grids[own.grid];
  own.cell = vec2<u32>((k - grid.first) % grid.width, (k - grid.first) / grid.width);
  let tile = own.cell / 4u;
  let node = kin[kin[kin[2] + 2u * own.grid]] + tile.y * ((grid.width + 3u) / 4u) + tile.x;
  own.reach = boxes[2u * node].w;
  own.at = p.xyz;
  own.home = homes[k].xyz;
  let wide = vec3<f32>(bitcast<f32>(kin[0]) * 0.5 + own.reach);
  own.low = p.xyz - wide;
  own.high = p.xyz + wide;
  return own;
}

@compute @workgroup_size(64)
fn main(
  @builtin(workgroup_id) workgroup: vec3<u32>,
  @builtin(num_workgroups) rows: vec3<u32>,
  @builtin(local_invocation_index) local: u32,
) {
  let k = element(workgroup, rows, local);
  if (k >= arrayLength(&now)) {
    return;
  }
  let p = now[k];
  if (p.w > 0.0) {
    let own = seeker(k, p);
    for (var g = 0u; g < arrayLength(&grids); g++) {
      search(own, g);
    }
  }
  for (var n = 0u; n < MAX_PARTNERS; n++) {
    let there = n < count;
    partners[k * MAX_PARTNERS + n] =
      vec2<u32>(select(NOBODY, who[n], there), bitcast<u32>(select(0.0, keep[n], there)));
  }
}
