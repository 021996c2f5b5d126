// The shortest way to what holds a particle, by way of the particles around it. A tether is the anchor's index, all ones
// for none, and the bits of its distance; beside it lie the group of its anchor and what supports it.
@group(0) @binding(38) var<storage, read_write> supports: array<u32>;

override slots: u32 = 1u;

// A distance that nothing reaches.
const FAR: f32 = 0x1.fffffep+127f;
const NONE: u32 = 0xffffffffu;

// The triangles around a texel, each quad split both ways: two of the circle, and the spring between them as the one of
// the two that stores it and its place there.
const CORNERS: array<vec4<u32>, 12> = array<vec4<u32>, 12>(
  vec4<u32>(0u, 1u, 0u, 1u), vec4<u32>(1u, 2u, 2u, 0u), vec4<u32>(0u, 2u, 2u, 3u), vec4<u32>(2u, 3u, 3u, 0u),
  vec4<u32>(3u, 4u, 4u, 1u), vec4<u32>(2u, 4u, 4u, 2u), vec4<u32>(4u, 5u, 5u, 1u), vec4<u32>(5u, 6u, 5u, 0u),
  vec4<u32>(4u, 6u, 4u, 3u), vec4<u32>(6u, 7u, 6u, 0u), vec4<u32>(7u, 0u, 7u, 1u), vec4<u32>(6u, 0u, 6u, 2u));

// The surroundings of a texel: each texel, the spring to it (0 for none), and how far it is from which pin of a group.
var<private> texel: array<u32, 8>;
var<private> long: array<f32, 8>;
var<private> away: array<f32, 8>;
var<private> end: array<u32, 8>;

fn grid_of(m: u32) -> Grid {
  var grid = grids[0];
  var more = true;
  for (var g = 1u; g < arrayLength(&grids) && more; g++) {
    let next = grids[g];
    more = next.first <= m;
    if (more) {
      grid = next;
    }
  }
  return grid;
}

// The texel at a place of the circle around another (right, down-right, down, down-left, left, up-left, up, up-right);
// itself where the grid ends. Steps and one lie in two bits each.
fn beside(grid: Grid, m: u32, c: u32) -> u32 {
  let here = vec2<u32>((m - grid.first) % grid.width, (m - grid.first) / grid.width);
  let at = vec2<i32>(here + ((vec2<u32>(0x901au, 0x01a9u) >> vec2<u32>(2u * c)) & vec2<u32>(3u))) - vec2<i32>(1);
  if (at.x < 0 || at.y < 0 || at.x >= i32(grid.width) || at.y >= i32(grid.height)) {
    return m;
  }
  return grid.first + u32(at.y) * grid.width + u32(at.x);
}

fn look(m: u32, group: u32) {
  let grid = grid_of(m);
  for (var c = 0u; c < 8u; c++) {
    texel[c] = m;
    long[c] = 0.0;
    away[c] = FAR;
    end[c] = NONE;
    let n = beside(grid, m, c);
    if (n == m) {
      continue;
    }
    texel[c] = n;
    // Springs to the fourth up to the seventh are stored there.
    long[c] = rest[select(n, m, c < 3u || c == 7u)][(0xd8d8u >> (2u * c)) & 3u];
    for (var s = 0u; s < slots; s++) {
      let t = n * slots + s;
      if (supports[2u * t] == group) {
        end[c] = tethers[t].x;
        away[c] = bitcast<f32>(tethers[t].y);
        break;
      }
    }
  }
}

// How far the texel at the other end of a stitch is from which pin of a group, as the bits of the distance and the pin.
fn away_over(e: u32, group: u32) -> vec2<u32> {
  let n = bridge_to(e);
  var found = vec2<u32>(NONE, bitcast<u32>(FAR));
  for (var s = 0u; s < slots; s++) {
    let t = n * slots + s;
    if (supports[2u * t] == group) {
      found = tethers[t];
      break;
    }
  }
  return found;
}

// How far C is from a point that is `far_a` from A and `far_b` from B, straight through the side `ab`; FAR where the line
// goes past that side.
fn unfold(far_a: f32, far_b: f32, ab: f32, ac: f32, bc: f32) -> f32 {
  // A at the origin, B along x, C below and the point above. Differences of squares as products: they lose less.
  let half = 0.5 / ab;
  let cx = ((ac - bc) * (ac + bc) + ab * ab) * half;
  let sx = ((far_a - far_b) * (far_a + far_b) + ab * ab) * half;
  let c2 = (ac - cx) * (ac + cx);
  let s2 = (far_a - sx) * (far_a + sx);
  if (c2 > 0.0 && s2 >= 0.0) {
    let cy = sqrt(c2);
    let sy = sqrt(s2);
    let height = cy + sy;
    let across = sx * cy + cx * sy;
    if (across >= 0.0 && across <= ab * height) {
      return sqrt((cx - sx) * (cx - sx) + height * height);
    }
  }
  return FAR;
}

// The spring between the two of one of the triangles, 0 where any of its springs is missing.
fn side(e: vec4<u32>) -> f32 {
  if (long[e.x] > 0.0 && long[e.y] > 0.0) {
    return rest[texel[e.z]][e.w];
  }
  return 0.0;
}

// The way through one of the triangles; FAR where a spring is missing or the way does not lead through it.
fn through(e: vec4<u32>) -> f32 {
  let ab = side(e);
  if (ab <= 0.0) {
    return FAR;
  }
  return unfold(away[e.x], away[e.y], ab, long[e.x], long[e.y]);
}

// Support of a tether. 0: particles nearer to its pin hang on that pin too, and the path through them, along a spring,
// across a triangle or over a stitch, is at most as long as the tether; a share of 1e-4 is rounding. Else, beside pins that share the cloth,
// paths may lead between particles that hang on others: UNSUPPORTED minus the number of springs, triangles, stitches and
// nearer particles around it; UNSUPPORTED if no particle is nearer.
fn support(k: u32, tether: vec2<u32>, group: u32) -> u32 {
  let own = bitcast<f32>(tether.y);
  var way = FAR;
  var nearer = 0u;
  var there = 0u;
  var corners = CORNERS;
  var m = k;
  for (var start = true; start || m != k; start = false) {
    look(m, group);
    for (var c = 0u; c < 8u; c++) {
      there += u32(long[c] > 0.0);
      nearer += u32(away[c] < own);
      if (long[c] > 0.0 && away[c] < own && end[c] == tether.x) {
        way = min(way, away[c] + long[c]);
      }
    }
    for (var t = 0u; t < 12u; t++) {
      let e = corners[t];
      there += u32(side(e) > 0.0);
      if (max(away[e.x], away[e.y]) < own && end[e.x] == tether.x && end[e.y] == tether.x) {
        way = min(way, through(e));
      }
    }
    let last = bridges_from(m + 1u);
    for (var e = bridges_from(m); e < last; e++) {
      let over = away_over(e, group);
      let far = bitcast<f32>(over.y);
      let by = bridge_length(e);
      there += u32(by > 0.0);
      nearer += u32(far < own);
      if (by > 0.0 && far < own && over.x == tether.x) {
        way = min(way, far + by);
      }
    }
    m = mate(m);
  }
  if (way <= own * 1.0001) {
    return 0u;
  }
  return UNSUPPORTED - select(0u, nearer + there, nearer > 0u);
}

// Of two ways, an anchor and the bits of a distance each, the shorter one; ties go to the lower anchor. The bits of
// numbers that are not negative are in their order.
fn shorter(a: vec2<u32>, b: vec2<u32>) -> vec2<u32> {
  let less = b.y < a.y || (b.y == a.y && b.x < a.x);
  return select(a, b, less);
}

// The shortest way to any anchor of a group by way of any neighbour.
fn nearest(k: u32, group: u32) -> vec2<u32> {
  var best = vec2<u32>(NONE, bitcast<u32>(FAR));
  var corners = CORNERS;
  var m = k;
  for (var start = true; start || m != k; start = false) {
    look(m, group);
    for (var c = 0u; c < 8u; c++) {
      if (long[c] > 0.0 && away[c] < FAR) {
        best = shorter(best, vec2<u32>(end[c], bitcast<u32>(away[c] + long[c])));
      }
    }
    for (var t = 0u; t < 12u; t++) {
      let e = corners[t];
      if (max(away[e.x], away[e.y]) < FAR && end[e.x] == end[e.y]) {
        best = shorter(best, vec2<u32>(end[e.x], bitcast<u32>(through(e))));
      }
    }
    let last = bridges_from(m + 1u);
    for (var e = bridges_from(m); e < last; e++) {
      let over = away_over(e, group);
      let by = bridge_length(e);
      if (by > 0.0 && bitcast<f32>(over.y) < FAR) {
        best = shorter(best, vec2<u32>(over.x, bitcast<u32>(bitcast<f32>(over.y) + by)));
      }
    }
    m = mate(m);
  }
  return best;
}
