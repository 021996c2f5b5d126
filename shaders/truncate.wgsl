// Puts each particle as near to where it wants to be in a round as its half-spaces let it, of all cloths with contact. One thread per texel of a
// tile, tile by tile; the first duplicate of a point puts all. `part` has the number of the round. It goes down the boxes of all grids for each of the four cells around each duplicate.
@group(0) @binding(53) var<uniform> part: vec4<f32>;
@group(0) @binding(69) var<storage, read> boxes: array<vec4<f32>>;
@group(0) @binding(86) var<storage, read> goals: array<vec4<f32>>;
@group(0) @binding(87) var<storage, read_write> places: array<vec4<f32>>;
@group(0) @binding(88) var<storage, read> bases: array<vec4<f32>>;
@group(0) @binding(89) var<storage, read> ways: array<vec4<f32>>;
@group(0) @binding(91) var<storage, read_write> counts: array<atomic<u32>>;

// The cells around a duplicate, by the corner that it is there: place, column and row, and box. A cell that is not there has an empty box.
var<private> own: Sheet;
var<private> own_tile: vec2<u32>;
var<private> own_place: array<u32, 4>;
var<private> own_at: array<vec2<u32>, 4>;
var<private> own_low: array<vec3<f32>, 4>;
var<private> own_high: array<vec3<f32>, 4>;
// Around all of them.
var<private> star_low: vec3<f32>;
var<private> star_high: vec3<f32>;
// Whether the tiles around cannot meet one another.
var<private> calm: bool;

// The pair of cells that are compared: corners, their points and their boxes, and features.
var<private> mine_k: vec4<u32>;
var<private> mine_bits: u32;
var<private> mine_corner: u32;
var<private> mine_place: u32;
var<private> theirs: Sheet;
var<private> theirs_k: vec4<u32>;
var<private> theirs_bits: u32;
var<private> theirs_place: u32;
var<private> theirs_low: array<vec3<f32>, 4>;
var<private> theirs_high: array<vec3<f32>, 4>;
// For each own corner the corners of the other cell at the same point.
var<private> same: vec4<u32>;
var<private> gap_least: f32;

fn overlap(low: vec3<f32>, high: vec3<f32>, a: vec3<f32>, b: vec3<f32>) -> bool {
  return all(low <= b) && all(a <= high);
}

fn bits_at(place: u32) -> u32 {
  return u32(boxes[cell_at(place)].w);
}

fn ball_at(k: u32) -> vec4<f32> {
  let base = bases[k];
  return vec4<f32>(base.xyz + ways[k].xyz * 0.5, base.w);
}

// Particles at the corners of a cell, around it from the upper left one downwards.
fn corners_of(sheet: Sheet, at: vec2<u32>) -> vec4<u32> {
  let k = sheet.first + at.y * sheet.width + at.x;
  return vec4<u32>(k, k + sheet.width, k + sheet.width + 1u, k + 1u);
}

// Whether no two features in the tiles around that of the texel that share no point can meet.
fn is_calm(k: u32) -> bool {
  let columns = (own.width + 3u) / 4u;
  let lines = (own.height + 3u) / 4u;
  var right_low = vec4<f32>(FARTHEST, FARTHEST, FARTHEST, 0.0);
  var right_high = vec4<f32>(-FARTHEST, -FARTHEST, -FARTHEST, 1.0);
  var down_low = right_low.xyz;
  var down_high = right_high.xyz;
  for (var n = 0u; n < 9u; n++) {
    // Wraps before the first one.
    let at = own_tile + vec2<u32>(n % 3u, n / 3u) - vec2<u32>(1u);
    if (at.x < columns && at.y < lines) {
      let spread = spread_at(own.tile + at.y * columns + at.x);
      let low = boxes[spread];
      let high = boxes[spread + 1u];
      right_low = vec4<f32>(min(right_low.xyz, low.xyz), max(right_low.w, low.w));
      right_high = vec4<f32>(max(right_high.xyz, high.xyz), min(right_high.w, high.w));
      down_low = min(down_low, boxes[spread + 2u].xyz);
      down_high = max(down_high, boxes[spread + 3u].xyz);
    }
  }
  let a = (right_low.xyz + right_high.xyz) * 0.5;
  let b = (down_low + down_high) * 0.5;
  let off_a = (right_high.xyz - right_low.xyz) * 0.5;
  let off_b = (down_high - down_low) * 0.5;
  let long_a = sqrt(dot(a, a));
  let long_b = sqrt(dot(b, b));
  let both = abs(dot(a, b));
  let left = min(long_a - both / max(long_a, 1e-37), long_b - both / max(long_b, 1e-37));
  let off = sqrt(dot(off_a, off_a)) + sqrt(dot(off_b, off_b));
  let gap = floor_at(own.spacing, bases[k].xyz);
  let apart = 0.999 * (left - off) > 2.0 * right_low.w + gap;
  return own.width > 2u && own.height > 2u && right_high.w > 0.0 && apart;
}

fn begin_cell(corner: u32, at: vec2<u32>, before: vec2<u32>) {
  own_low[corner] = vec3<f32>(FARTHEST);
  own_high[corner] = vec3<f32>(-FARTHEST);
  if (all(before <= at)) {
    own_at[corner] = at - before;
    own_place[corner] = place_of(own, at - before);
    let cell = cell_at(own_place[corner]);
    own_low[corner] = boxes[cell].xyz;
    own_high[corner] = boxes[cell + 1u].xyz;
  }
  star_low = min(star_low, own_low[corner]);
  star_high = max(star_high, own_high[corner]);
}

// Begins with a duplicate of the particle.
fn begin_star(k: u32, sheet: Sheet) {
  own = sheet;
  let at = vec2<u32>((k - own.first) % own.width, (k - own.first) / own.width);
  own_tile = at / 4u;
  star_low = vec3<f32>(FARTHEST);
  star_high = vec3<f32>(-FARTHEST);
  begin_cell(0u, at, vec2<u32>(0u, 0u));
  begin_cell(1u, at, vec2<u32>(0u, 1u));
  begin_cell(2u, at, vec2<u32>(1u, 1u));
  begin_cell(3u, at, vec2<u32>(1u, 0u));
  calm = is_calm(k);
}

// Whether the box of the n-th cell of a tile meets those around the particle, as the n-th bit.
fn hit(tile: u32, n: u32) -> u32 {
  let cell = cell_at(16u * tile + n);
  return select(0u, 1u << n, overlap(star_low, star_high, boxes[cell].xyz, boxes[cell + 1u].xyz));
}

fn hits_of(tile: u32) -> u32 {
  let first = hit(tile, 0u) | hit(tile, 1u) | hit(tile, 2u) | hit(tile, 3u);
  let second = hit(tile, 4u) | hit(tile, 5u) | hit(tile, 6u) | hit(tile, 7u);
  let third = hit(tile, 8u) | hit(tile, 9u) | hit(tile, 10u) | hit(tile, 11u);
  return first | second | third | hit(tile, 12u) | hit(tile, 13u) | hit(tile, 14u) | hit(tile, 15u);
}

// The line of texels between two cells, or one beside a single one; 0 if there is none.
fn line_between(at: u32, other: u32, count: u32) -> u32 {
  let beside = other + 1u >= at && other <= at + 1u;
  var line = select(at + 1u, at, other < at);
  line = select(line, min(line, count - 2u), other == at);
  return select(0u, line, count > 2u && beside && line + 1u < count);
}

// Whether two cells of the grid lie in an even block.
fn are_even(at: vec2<u32>, other: vec2<u32>) -> bool {
  let line = vec2<u32>(line_between(at.x, other.x, own.width), line_between(at.y, other.y, own.height));
  if (line.x == 0u || line.y == 0u) {
    return false;
  }
  return bit(bits_at(place_of(own, line)), 20u);
}

// Of the cells around the particle those that may meet a cell, as bits.
fn cells_that_meet(at: vec2<u32>, place: u32) -> u32 {
  let low = boxes[cell_at(place)].xyz;
  let high = boxes[cell_at(place) + 1u].xyz;
  var meets = 0u;
  for (var corner = 0u; corner < 4u; corner++) {
    if (overlap(own_low[corner], own_high[corner], low, high)) {
      let even = theirs.number == own.number && are_even(own_at[corner], at);
      meets |= select(1u << corner, 0u, even);
    }
  }
  return meets;
}

// The corners of an edge of a cell.
fn ends_of(edge: u32) -> vec2<u32> {
  return select(vec2<u32>(edge - 4u, edge - 2u), vec2<u32>(edge, (edge + 1u) % 4u), edge < 4u);
}

// The corners of a triangle of a cell, as bits; none of one that it has not.
fn triangle_of(bits: u32, n: u32) -> u32 {
  return select(0u, (bits >> (2u + 4u * n)) & 15u, bit(bits, n));
}

// The three corners of a triangle.
fn three_of(corners: u32) -> vec3<u32> {
  let rest = corners & (corners - 1u);
  return vec3<u32>(firstTrailingBit(corners), firstTrailingBit(rest), firstTrailingBit(rest & (rest - 1u)));
}

// Whether a feature of the other cell meets a box and shares no point: corners, and ties with the own feature, are bits.
fn meets(corners: u32, ties: u32, low: vec3<f32>, high: vec3<f32>) -> bool {
  var a = vec3<f32>(FARTHEST);
  var b = vec3<f32>(-FARTHEST);
  for (var n = 0u; n < 4u; n++) {
    let part = bit(corners, n);
    a = select(a, min(a, theirs_low[n]), part);
    b = select(b, max(b, theirs_high[n]), part);
  }
  return corners != 0u && (corners & ties) == 0u && overlap(low, high, a, b);
}

// The corners of the other cell at the points of some own corners.
fn tied_to(corners: u32) -> u32 {
  let bits = vec4<u32>(corners, corners >> 1u, corners >> 2u, corners >> 3u) & vec4<u32>(1u);
  let found = same * bits;
  return found.x | found.y | found.z | found.w;
}

// The pairs of features of two cells that may meet, the own one with the particle: 3 times 6 of edges, 2 times 4 of an own triangle and a vertex,
// and 2 of the particle and a triangle.
fn pairs_of(corner: u32) -> u32 {
  mine_corner = corner;
  mine_place = own_place[corner];
  mine_k = corners_of(own, own_at[corner]);
  mine_bits = bits_at(mine_place);
  let used = triangle_of(mine_bits, 0u) | triangle_of(mine_bits, 1u);
  var lows = array<vec3<f32>, 4>();
  var highs = array<vec3<f32>, 4>();
  same = vec4<u32>(0u);
  let own_gap = floor_at(own.spacing, bases[mine_k[corner]].xyz);
  gap_least = max(own_gap, floor_at(theirs.spacing, bases[theirs_k[firstTrailingBit((theirs_bits >> 2u) | (theirs_bits >> 6u)) % 4u]].xyz));
  for (var n = 0u; n < 4u; n++) {
    if (bit(used, n)) {
      let ball = ball_at(mine_k[n]);
      lows[n] = ball.xyz - (ball.w + gap_least);
      highs[n] = ball.xyz + (ball.w + gap_least);
      let point = point_of(mine_k[n]);
      let points = vec4<u32>(point_of(theirs_k.x), point_of(theirs_k.y), point_of(theirs_k.z), point_of(theirs_k.w));
      same[n] = dot(select(vec4<u32>(0u), vec4<u32>(1u, 2u, 4u, 8u), points == vec4<u32>(point)), vec4<u32>(1u));
    }
  }
  var pairs = 0u;
  for (var slot = 0u; slot < 3u; slot++) {
    let edge = edge_of(slot);
    let ends = ends_of(edge);
    if (bit(mine_bits, 10u + edge)) {
      let ties = tied_to((1u << ends.x) | (1u << ends.y));
      let low = min(lows[ends.x], lows[ends.y]);
      let high = max(highs[ends.x], highs[ends.y]);
      for (var n = 0u; n < 6u; n++) {
        let others = ends_of(n);
        let there = bit(theirs_bits, 10u + n);
        pairs |= select(0u, 1u << (6u * slot + n), there && meets((1u << others.x) | (1u << others.y), ties, low, high));
      }
    }
  }
  for (var t = 0u; t < 2u; t++) {
    let triangle = triangle_of(mine_bits, t);
    if (bit(triangle, corner)) {
      let three = three_of(triangle);
      let ties = tied_to(triangle);
      let low = min(lows[three.x], min(lows[three.y], lows[three.z]));
      let high = max(highs[three.x], max(highs[three.y], highs[three.z]));
      for (var n = 0u; n < 4u; n++) {
        let there = bit(theirs_bits, 16u + n);
        pairs |= select(0u, 1u << (18u + 4u * t + n), there && meets(1u << n, ties, low, high));
      }
    }
  }
  if (bit(mine_bits, 16u + corner)) {
    for (var t = 0u; t < 2u; t++) {
      let meets_it = meets(triangle_of(theirs_bits, t), tied_to(1u << corner), lows[corner], highs[corner]);
      pairs |= select(0u, 1u << (26u + t), meets_it);
    }
  }
  return pairs;
}

// The edges of an own cell at the particle: around the cell in both directions, and across it.
fn edge_of(slot: u32) -> u32 {
  return select(select((mine_corner + 3u) % 4u, mine_corner, slot == 0u), 4u + mine_corner % 2u, slot == 2u);
}

// Takes in what keeps the particle apart in a pair of features.
fn keep_apart(pair: u32) {
  var four = vec4<u32>(0u);
  var who = 0u;
  let edges = pair < 18u;
  if (edges) {
    let edge = edge_of(pair / 6u);
    let ends = ends_of(edge);
    let others = ends_of(pair % 6u);
    let mine = vec2<u32>(mine_k[ends.x], mine_k[ends.y]);
    let their = vec2<u32>(theirs_k[others.x], theirs_k[others.y]);
    // Both sides of a pair have it in the same order.
    let first = 6u * mine_place + edge < 6u * theirs_place + pair % 6u;
    four = select(vec4<u32>(their, mine), vec4<u32>(mine, their), first);
    who = select(2u, 0u, first) + select(0u, 1u, ends.y == mine_corner);
  } else if (pair < 26u) {
    let corners = three_of(triangle_of(mine_bits, (pair - 18u) / 4u));
    four = vec4<u32>(theirs_k[(pair - 18u) % 4u], mine_k[corners.x], mine_k[corners.y], mine_k[corners.z]);
    who = select(select(3u, 2u, corners.y == mine_corner), 1u, corners.x == mine_corner);
  } else {
    let corners = three_of(triangle_of(theirs_bits, pair - 26u));
    four = vec4<u32>(mine_k[mine_corner], theirs_k[corners.x], theirs_k[corners.y], theirs_k[corners.z]);
  }
  take(bound_of(four, edges, who, gap_least));
}

// Compares with the n-th cell of a tile: the cells around the particle that may meet it, as bits.
fn begin_pair(tile: u32, n: u32) -> u32 {
  theirs = sheet_of_tile(tile);
  theirs_place = 16u * tile + n;
  let at = corner_of_tile(tile) + vec2<u32>(n % 4u, n / 4u);
  theirs_k = corners_of(theirs, at);
  theirs_bits = bits_at(theirs_place);
  let used = triangle_of(theirs_bits, 0u) | triangle_of(theirs_bits, 1u);
  for (var corner = 0u; corner < 4u; corner++) {
    if (bit(used, corner)) {
      let ball = ball_at(theirs_k[corner]);
      theirs_low[corner] = ball.xyz - ball.w;
      theirs_high[corner] = ball.xyz + ball.w;
    }
  }
  return cells_that_meet(at, theirs_place);
}

// The grid of a duplicate, most often that of the first one.
fn sheet_of(k: u32, sheet: Sheet) -> Sheet {
  var found = sheet;
  let count = kin[0];
  var g = 0u;
  while (g < count && !(k >= found.first && k < found.first + found.width * found.height)) {
    found = sheet_at(g);
    g += 1u;
  }
  return found;
}

// Takes in all features near those of the particle. One loop does one thing at a time, so that the number of its turns is known: software adapters
// end all loops of a thread after a number of them.
fn search(k: u32, sheet: Sheet) {
  var mate = k;
  var turns = 0u;
  var g = 0u;
  var level = 0u;
  var at = vec2<u32>(0u);
  var descends = false;
  var tile = 0u;
  var cells = 0u;
  var stars = 0u;
  var pairs = 0u;
  begin_star(k, sheet);
  var going = true;
  while (going && turns < MAX_TURNS) {
    turns += 1u;
    if (pairs != 0u) {
      keep_apart(firstTrailingBit(pairs));
      pairs &= pairs - 1u;
    } else if (stars != 0u) {
      pairs = pairs_of(firstTrailingBit(stars));
      stars &= stars - 1u;
    } else if (cells != 0u) {
      stars = begin_pair(tile, firstTrailingBit(cells));
      cells &= cells - 1u;
    } else if (descends) {
      let top = kin[kin[2] + 2u * g + 1u] - 1u;
      let row = kin[kin[2] + 2u * g] + 3u * level;
      let sides = vec2<u32>(kin[row + 1u], kin[row + 2u]);
      var inside = false;
      if (all(at < sides)) {
        let node = kin[row] + at.y * sides.x + at.x;
        inside = overlap(star_low, star_high, boxes[2u * node].xyz, boxes[2u * node + 1u].xyz);
        if (inside && level == 0u) {
          let beside = all(at <= own_tile + vec2<u32>(1u)) && all(own_tile <= at + vec2<u32>(1u));
          tile = node;
          cells = select(hits_of(node), 0u, calm && g == own.number && beside);
        }
      }
      if (inside && level > 0u) {
        level -= 1u;
        at = 2u * at;
      } else {
        while (level < top && (at.x & at.y & 1u) == 1u) {
          level += 1u;
          at = at / 2u;
        }
        descends = level < top;
        g += select(1u, 0u, descends);
        at = select(vec2<u32>(at.x + 1u, at.y), vec2<u32>(at.x - 1u, at.y + 1u), (at.x & 1u) == 1u);
      }
    } else if (g < kin[0]) {
      level = kin[kin[2] + 2u * g + 1u] - 1u;
      at = vec2<u32>(0u);
      descends = true;
    } else {
      mate = kin[kin[5] + mate];
      going = mate != k;
      if (going) {
        begin_star(mate, sheet_of(mate, sheet));
        g = 0u;
      }
    }
  }
  // One that would need more turns stays where it is, and is counted.
  if (going) {
    room_still = true;
    atomicAdd(&counts[COUNT_SLOWED], 1u);
  }
}

// Whether all duplicates of a particle may be held back.
fn is_free(k: u32) -> bool {
  var free = ways[k].w > 0.0;
  var mate = kin[kin[5] + k];
  while (free && mate != k) {
    free = ways[mate].w > 0.0;
    mate = kin[kin[5] + mate];
  }
  return free;
}

// Where a particle goes.
fn put(k: u32, sheet: Sheet) -> vec3<f32> {
  let base = bases[k];
  let way = ways[k];
  let goal = goals[k].xyz;
  let all_of_it = goal - base.xyz;
  let clamped = dot(all_of_it, all_of_it) > dot(way.xyz, way.xyz) * 1.0001;
  let end = select(goal, base.xyz + way.xyz, clamped);
  if (all(end == base.xyz)) {
    return end;
  }
  begin_room(base, way.xyz, sheet.spacing);
  search(k, sheet);
  var to = end;
  if (!has_room(end - base.xyz)) {
    if (is_free(k)) {
      to = clip(base.xyz, project());
    } else {
      atomicAdd(&counts[COUNT_FORCED], 1u);
    }
  }
  // Half-spaces that held it would hold it in a further round too.
  let gone = to - base.xyz;
  if (clamped && dot(gone, gone) > 0.25 * dot(way.xyz, way.xyz)) {
    let round = u32(part.x);
    if (round + 1u < HELD_ROUNDS) {
      atomicMax(&counts[COUNT_MORE + round], 1u);
    } else {
      atomicAdd(&counts[COUNT_SLOWED], 1u);
    }
  }
  return to;
}

@compute @workgroup_size(64)
fn main(
  @builtin(workgroup_id) workgroup: vec3<u32>,
  @builtin(num_workgroups) rows: vec3<u32>,
  @builtin(local_invocation_index) local: u32,
) {
  let n = element(workgroup, rows, local);
  let tile = n / 16u;
  let round = u32(part.x);
  if (tile >= kin[4] || (round > 0u && atomicLoad(&counts[COUNT_MORE + max(round, 1u) - 1u]) == 0u)) {
    return;
  }
  let sheet = sheet_of_tile(tile);
  let at = corner_of_tile(tile) + vec2<u32>(n % 4u, n / 4u % 4u);
  if (sheet.spacing <= 0.0 || at.x >= sheet.width || at.y >= sheet.height) {
    return;
  }
  let k = sheet.first + at.y * sheet.width + at.x;
  if (point_of(k) != k) {
    return;
  }
  let to = put(k, sheet);
  places[k] = vec4<f32>(to, 0.0);
  var mate = kin[kin[5] + k];
  while (mate != k) {
    places[mate] = vec4<f32>(to, 0.0);
    mate = kin[kin[5] + mate];
  }
}
