// How far particles want to go in a round, and boxes around the cells wherever their particles may be then, of all cloths with contact. One
// thread per texel of a tile, tile by tile. Bases: where a particle is, and the radius of the ball around the middle of its way in which it stays.
// Further rounds do nothing where no particle has farther to go. `part` has the number of the round. Two vectors per box: its low corner, with the features of the cell (shaders/faces.wgsl) and whether the block around the texel is even, and its
// high corner. Four vectors per tile: bounds of the edges along rows and along columns.
@group(0) @binding(53) var<uniform> part: vec4<f32>;
@group(0) @binding(69) var<storage, read_write> boxes: array<vec4<f32>>;
@group(0) @binding(86) var<storage, read> goals: array<vec4<f32>>;
@group(0) @binding(87) var<storage, read> places: array<vec4<f32>>;
@group(0) @binding(88) var<storage, read_write> bases: array<vec4<f32>>;
@group(0) @binding(89) var<storage, read_write> ways: array<vec4<f32>>;
@group(0) @binding(90) var<storage, read> faces: array<u32>;
@group(0) @binding(91) var<storage, read_write> counts: array<atomic<u32>>;

// Of each texel of the workgroup's tiles: the box of its cell, bounds of the edges, and, as w, the largest radius and whether all is even.
var<workgroup> lows: array<vec4<f32>, 64>;
var<workgroup> highs: array<vec4<f32>, 64>;
var<workgroup> right_lows: array<vec4<f32>, 64>;
var<workgroup> right_highs: array<vec4<f32>, 64>;
var<workgroup> down_lows: array<vec4<f32>, 64>;
var<workgroup> down_highs: array<vec4<f32>, 64>;

// The way of a particle in the round; w is its mark.
fn way_of(k: u32, spacing: f32) -> vec4<f32> {
  let goal = goals[k];
  let way = goal.xyz - places[k].xyz;
  let far = sqrt(dot(way, way));
  let most = spacing * MAX_WAY;
  return vec4<f32>(way * select(1.0, most / far, far > most && goal.w > 0.0), goal.w);
}

// The radius of its ball.
fn radius_of(place: vec3<f32>, way: vec4<f32>, spacing: f32) -> f32 {
  let rounding = max(largest(place), largest(way.xyz)) * HELD_ROUNDING;
  return 0.500005 * sqrt(dot(way.xyz, way.xyz)) + select(0.0, spacing * ASIDE_SHARE, way.w > 0.0) + rounding;
}

fn ball_of(k: u32, spacing: f32) -> vec4<f32> {
  let way = way_of(k, spacing);
  let place = places[k].xyz;
  return vec4<f32>(place + way.xyz * 0.5, radius_of(place, way, spacing));
}

// Whether the block around a texel is even, the texel being an inner one.
fn even_at(sheet: Sheet, k: u32) -> bool {
  var balls = array<vec4<f32>, 9>();
  var whole = true;
  for (var n = 0u; n < 9u; n++) {
    let m = k + n / 3u * sheet.width + n % 3u - sheet.width - 1u;
    whole = whole && point_of(m) != NOBODY;
    balls[n] = ball_of(m, sheet.spacing);
  }
  return whole && is_even(balls, floor_at(sheet.spacing, places[k].xyz));
}

fn bound(tile: u32, lane: u32, local: u32) {
  let sheet = sheet_of_tile(tile);
  let at = corner_of_tile(tile) + vec2<u32>(lane % 4u, lane / 4u);
  var low = vec3<f32>(FARTHEST);
  var high = vec3<f32>(-FARTHEST);
  var right = array<vec3<f32>, 2>(low, high);
  var down = array<vec3<f32>, 2>(low, high);
  var reach = 0.0;
  var bits = 0u;
  var even = true;
  if (sheet.spacing > 0.0 && at.x < sheet.width && at.y < sheet.height) {
    let k = sheet.first + at.y * sheet.width + at.x;
    let place = places[k].xyz;
    if (point_of(k) != NOBODY) {
      let way = way_of(k, sheet.spacing);
      ways[k] = way;
      bases[k] = vec4<f32>(place, radius_of(place, way, sheet.spacing));
    }
    bits = faces[k];
    if (at.x > 0u && at.y > 0u && at.x + 1u < sheet.width && at.y + 1u < sheet.height) {
      even = even_at(sheet, k);
      bits |= select(0u, 1u << 20u, even);
    }
    if (at.x + 1u < sheet.width && at.y + 1u < sheet.height) {
      let gap = floor_at(sheet.spacing, place);
      var balls = array<vec4<f32>, 4>();
      for (var n = 0u; n < 4u; n++) {
        let m = k + select(0u, sheet.width, n == 1u || n == 2u) + n / 2u;
        if ((bits & 3u) > 0u && point_of(m) != NOBODY) {
          balls[n] = ball_of(m, sheet.spacing);
          low = min(low, balls[n].xyz - balls[n].w - gap);
          high = max(high, balls[n].xyz + balls[n].w + gap);
          reach = max(reach, balls[n].w);
        }
      }
      even = even && (bits & 3u) == 3u;
      let upper = balls[3].xyz - balls[0].xyz;
      let lower = balls[2].xyz - balls[1].xyz;
      right = array<vec3<f32>, 2>(min(upper, lower), max(upper, lower));
      let before = balls[1].xyz - balls[0].xyz;
      let behind = balls[2].xyz - balls[3].xyz;
      down = array<vec3<f32>, 2>(min(before, behind), max(before, behind));
    }
  }
  let cell = cell_at(16u * tile + lane);
  boxes[cell] = vec4<f32>(low, f32(bits));
  boxes[cell + 1u] = vec4<f32>(high, 0.0);
  lows[local] = vec4<f32>(low, 0.0);
  highs[local] = vec4<f32>(high, 0.0);
  right_lows[local] = vec4<f32>(right[0], reach);
  right_highs[local] = vec4<f32>(right[1], select(0.0, 1.0, even));
  down_lows[local] = vec4<f32>(down[0], 0.0);
  down_highs[local] = vec4<f32>(down[1], 0.0);
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
  let runs = tile < kin[4] && (round == 0u || atomicLoad(&counts[COUNT_MORE + max(round, 1u) - 1u]) > 0u);
  if (runs) {
    bound(tile, n % 16u, local);
  }
  workgroupBarrier();
  if (runs && local % 16u == 0u) {
    var low = lows[local];
    var high = highs[local];
    var right_low = right_lows[local];
    var right_high = right_highs[local];
    var down_low = down_lows[local];
    var down_high = down_highs[local];
    for (var m = local + 1u; m < local + 16u; m++) {
      low = min(low, lows[m]);
      high = max(high, highs[m]);
      let reach = max(right_low.w, right_lows[m].w);
      let even = min(right_high.w, right_highs[m].w);
      right_low = vec4<f32>(min(right_low.xyz, right_lows[m].xyz), reach);
      right_high = vec4<f32>(max(right_high.xyz, right_highs[m].xyz), even);
      down_low = min(down_low, down_lows[m]);
      down_high = max(down_high, down_highs[m]);
    }
    boxes[2u * tile] = low;
    boxes[2u * tile + 1u] = high;
    let spread = spread_at(tile);
    boxes[spread] = right_low;
    boxes[spread + 1u] = right_high;
    boxes[spread + 2u] = down_low;
    boxes[spread + 3u] = down_high;
  }
  if (n == 0u && round == 0u) {
    // The largest counts of all steps of the frame so far; those of this step are added by shaders/truncate.wgsl.
    atomicMax(&counts[COUNT_FORCED_MOST], atomicExchange(&counts[COUNT_FORCED], 0u));
    atomicMax(&counts[COUNT_SLOWED_MOST], atomicExchange(&counts[COUNT_SLOWED], 0u));
    for (var r = 0u; r + 1u < HELD_ROUNDS; r++) {
      atomicStore(&counts[COUNT_MORE + r], 0u);
    }
  }
}
