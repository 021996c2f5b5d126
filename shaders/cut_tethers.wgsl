// After a cut tethers stay where they are still true, grow where the way to the pin has become longer, and end where
// there is none. Many rounds, each from `tethers` to `holding` and the next one back: which phase a round is of, its
// turn (0, 1, 2, and so on), and whether it is the first and the last of its phase are in `action`. Once a round changes
// nothing, those after it have nothing to do. A thread a texel.
//
// Phase 0, before the cut: what supports each tether. Phase 1: a tether ends that has lost its support, and with it those
// that it supports; where rounds were too few to end all of them, all are taken for ended. Phase 2: those that ended take
// the shortest way that is left, as far as rounds go.
@group(0) @binding(39) var<storage, read_write> holding: array<vec2<u32>>;
// Whether the rounds of each turn have changed anything, and whether phase 1 ran out of rounds; then for each texel a bit
// for each turn: whether it has changed. Only beside such a texel can anything change in the next round.
@group(0) @binding(40) var<storage, read_write> changes: array<atomic<u32>>;

// In the place of a support.
const LOST: u32 = 0xffffffffu;

// Whether a tether that rested on `before` does so on `after`.
fn holds(before: u32, after: u32) -> bool {
  return after == 0u || (after < UNSUPPORTED && after == before);
}

// Whether anything beside a particle has changed in a turn.
fn stirred(k: u32, turn: u32) -> bool {
  var any = 0u;
  var m = k;
  for (var start = true; start || m != k; start = false) {
    let grid = grid_of(m);
    for (var c = 0u; c < 8u; c++) {
      any |= atomicLoad(&changes[4u + beside(grid, m, c)]);
    }
    m = mate(m);
  }
  return ((any >> turn) & 1u) != 0u;
}

@compute @workgroup_size(16, 4)
fn main(@builtin(global_invocation_id) id: vec3<u32>) {
  let phase = u32(action[0].x);
  let turn = u32(action[0].y);
  let first = action[0].z != 0.0;
  let last = action[0].w != 0.0;
  if (all(id == vec3<u32>(0u))) {
    if (phase == 0u) {
      atomicStore(&changes[0], 0u);
      atomicStore(&changes[1], 0u);
      atomicStore(&changes[2], 0u);
      atomicStore(&changes[3], 0u);
    } else {
      // For the next round; the one before the last has no reader any more.
      atomicStore(&changes[(turn + 1u) % 3u], 0u);
    }
  }
  let grid = grids[id.z];
  if (id.x >= grid.width || id.y >= grid.height) {
    return;
  }
  if (phase > 0u && !first && atomicLoad(&changes[(turn + 2u) % 3u]) == 0u) {
    return;
  }
  let all_lost = phase == 2u && first && atomicLoad(&changes[3]) != 0u;
  let k = grid.first + id.y * grid.width + id.x;
  let idle = phase > 0u && !first && !stirred(k, (turn + 2u) % 3u);
  var changed = false;
  for (var s = 0u; s < slots; s++) {
    let t = k * slots + s;
    let was = tethers[t];
    let own = bitcast<f32>(was.y);
    let group = supports[2u * t];
    var now = was;
    // Pins hang on themselves.
    if (!idle && was.x != NONE && own > 0.0) {
      if (phase == 0u) {
        supports[2u * t + 1u] = select(support(k, was, group), LOST, own >= FAR);
      } else if (phase == 1u) {
        if (own < FAR && !holds(supports[2u * t + 1u], support(k, was, group))) {
          now.y = bitcast<u32>(FAR);
          supports[2u * t + 1u] = LOST;
        }
      } else if (all_lost) {
        now.y = bitcast<u32>(FAR);
        supports[2u * t + 1u] = LOST;
        changed = true;
      } else if (supports[2u * t + 1u] == LOST) {
        let way = nearest(k, group);
        if (way.y < bitcast<u32>(FAR)) {
          now = shorter(was, way);
        }
      }
    }
    changed = changed || any(now != was);
    if (phase > 0u) {
      holding[t] = now;
    }
  }
  if (phase > 0u) {
    // The bit of this turn is clear; that of the next one is unused now.
    let kept = select(atomicLoad(&changes[4u + k]) & ~(1u << ((turn + 1u) % 3u)), 0u, first);
    atomicStore(&changes[4u + k], kept | (u32(changed) << turn));
  }
  if (changed) {
    atomicStore(&changes[turn], 1u);
    if (phase == 1u && last) {
      atomicStore(&changes[3], 1u);
    }
  }
}
