// For each particle the nearest particles of other cloths that it may meet until the next search, the nearest first: MAX_OTHERS times an
// index, all ones for none, the bits of the distance to keep and of the friction, and the particle's own index. One thread per particle, tile
// by tile, goes down the boxes of the grids of other cloths. `part` has the time until then. Notes cloths that are asleep and wake.
@group(0) @binding(53) var<uniform> part: vec4<f32>;
@group(0) @binding(67) var<storage, read> kin: array<u32>;
@group(0) @binding(68) var<storage, read> homes: array<vec4<f32>>;
@group(0) @binding(69) var<storage, read> boxes: array<vec4<f32>>;
@group(0) @binding(77) var<storage, read> shadows: array<vec4<f32>>;
@group(0) @binding(78) var<storage, read_write> others: array<vec4<u32>>;
@group(0) @binding(79) var<storage, read_write> struck: array<atomic<u32>>;

const NOBODY: u32 = 0xffffffffu;

// The particle that searches: its cloth, with distance and friction, where it is at rest and whether cloths cross there, and what it passes.
struct Seeker {
  cloth: u32,
  distance: f32,
  friction: f32,
  home: vec4<f32>,
  at: vec3<f32>,
  velocity: vec3<f32>,
  low: vec3<f32>,
  high: vec3<f32>,
}

// The nearest so far, the nearest first; of those equally near the one that comes first in the order of tiles.
var<private> count: u32 = 0u;
var<private> far: array<f32, MAX_OTHERS>;
var<private> place: array<u32, MAX_OTHERS>;
var<private> found: array<vec4<u32>, MAX_OTHERS>;

fn is_later(n: u32, near: f32, at: u32) -> bool {
  return far[n] > near || (far[n] == near && place[n] > at);
}

fn take(near: f32, at: u32, row: vec4<u32>) {
  let last = MAX_OTHERS - 1u;
  if (count > last && !is_later(last, near, at)) {
    return;
  }
  count = min(count + 1u, MAX_OTHERS);
  var n = count - 1u;
  while (n > 0u && is_later(n - 1u, near, at)) {
    far[n] = far[n - 1u];
    place[n] = place[n - 1u];
    found[n] = found[n - 1u];
    n -= 1u;
  }
  far[n] = near;
  place[n] = at;
  found[n] = row;
}

// The distance that two particles keep. Where cloths cross at rest, their distance there says nothing about it.
fn least_of(own: Seeker, distance: f32, m: u32) -> f32 {
  let whole = (own.distance + distance) * 0.5;
  let home = homes[m];
  let way = home.xyz - own.home.xyz;
  let rest = min(whole, sqrt(dot(way, way)) * REST_SHARE);
  return select(rest, whole, own.home.w > 0.0 && home.w > 0.0);
}

// Takes in the particles of a tile.
fn meet(own: Seeker, g: u32, corner: vec2<u32>, node: u32) {
  let grid = grids[g];
  let row = kin[7] + 8u * g;
  let distance = bitcast<f32>(kin[row + 1u]);
  let reach = (own.distance + distance) * SHADOW_WIDTH;
  for (var n = 0u; n < 16u; n++) {
    // The order of the twin: two even columns of a row, then two odd ones.
    let cell = 4u * corner + vec2<u32>(n / 2u % 2u + 2u * (n % 2u), n / 4u);
    if (cell.x < grid.width && cell.y < grid.height) {
      let m = grid.first + cell.y * grid.width + cell.x;
      // Of the duplicates of a point the first stands for all.
      if (kin[kin[3] + m] == m) {
        let way = shadows[2u * m].xyz - own.at;
        let other = shadows[2u * m + 1u];
        let speed = other.xyz - own.velocity;
        // When they are nearest, if they go on as they do.
        let time = min(max(-dot(way, speed) / max(dot(speed, speed), 1e-20), 0.0), part.x);
        let gap = way + speed * time;
        let near = dot(gap, gap);
        if (near < reach * reach) {
          let least = least_of(own, distance, m);
          let friction = (own.friction + bitcast<f32>(kin[row + 2u])) * 0.5;
          take(near, node * 16u + n, vec4<u32>(m, bitcast<u32>(least), bitcast<u32>(friction), 0u));
          if (dot(own.velocity, own.velocity) > other.w * other.w && near < least * least) {
            atomicMax(&struck[kin[row]], 1u);
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

@compute @workgroup_size(64)
fn main(
  @builtin(workgroup_id) workgroup: vec3<u32>,
  @builtin(num_workgroups) rows: vec3<u32>,
  @builtin(local_invocation_index) local: u32,
) {
  let n = element(workgroup, rows, local);
  let tile = n / 16u;
  if (tile >= kin[4]) {
    return;
  }
  let g = kin[kin[6] + 2u * tile];
  let corner = kin[kin[6] + 2u * tile + 1u];
  let cell = vec2<u32>(corner & 0xffffu, corner >> 16u) * 4u + vec2<u32>(n % 4u, n / 4u % 4u);
  if (cell.x >= grids[g].width || cell.y >= grids[g].height) {
    return;
  }
  let k = grids[g].first + cell.y * grids[g].width + cell.x;
  let row = kin[7] + 8u * g;
  let at = shadows[2u * k];
  // Pins and cloth that is asleep are not pushed.
  if (at.w > 0.0) {
    var own: Seeker;
    own.cloth = kin[row];
    own.distance = bitcast<f32>(kin[row + 1u]);
    own.friction = bitcast<f32>(kin[row + 2u]);
    own.home = homes[k];
    own.at = at.xyz;
    own.velocity = shadows[2u * k + 1u].xyz;
    let end = own.at + own.velocity * part.x;
    let wide = own.distance * SHADOW_WIDTH;
    own.low = min(own.at, end) - wide;
    own.high = max(own.at, end) + wide;
    for (var other = 0u; other < arrayLength(&grids); other++) {
      if (kin[kin[7] + 8u * other] != own.cloth) {
        search(own, other);
      }
    }
  }
  for (var slot = 0u; slot < MAX_OTHERS; slot++) {
    let there = slot < count;
    others[k * MAX_OTHERS + slot] = vec4<u32>(select(NOBODY, found[slot].x, there), found[slot].yz, k);
  }
}
