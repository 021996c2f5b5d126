// After a cut tethers stay where they are still true, grow where the way to the pin has become longer, and end where
// there is none. `action` has the numbers of a dispatch: the stage, or, for a walk, the phase and its limits.
//
// Stage 0, before the cut, finds the support of each tether. Phase 1: a tether ends that has lost its support, and with it
// those that it supports; where rounds were too few to end all of them, all are taken for ended. Phase 2: those that ended
// take the shortest way that is left, as far as rounds go.
//
// The first round of a phase is for all texels, a thread a texel: stages 1 and 3 find the tethers of phases 1 and 2, and
// stages 2 and 4 take them. Further rounds are for texels beside one that has changed in the round before, as nothing else
// can change: one workgroup walks through lists of them until a list is empty. A round reads the tethers of the one before
// alone, so that results do not depend on the order of a list.
@group(0) @binding(19) var<storage, read_write> tethers: array<vec2<u32>>;
// Tethers that a round has found: by texel, or, in a walk, by the place in its list.
@group(0) @binding(39) var<storage, read_write> holding: array<vec2<u32>>;
// The head, see below; for each texel the last round whose list has it; then two lists of texels.
@group(0) @binding(40) var<storage, read_write> changes: array<atomic<u32>>;

override walks: bool = false;
override threads_x: u32 = 16u;
override threads_y: u32 = 4u;

// Lengths of both lists, and the number of the last round.
const ROUND: u32 = 2u;
// Which list is to be walked through.
const TURN: u32 = 3u;
const STAMPS: u32 = 4u;
// In the place of a support.
const LOST: u32 = 0xffffffffu;
// Threads of a workgroup that walks.
const GROUP: u32 = 256u;

var<workgroup> shared_count: u32;

fn texels() -> u32 {
  return (arrayLength(&changes) - STAMPS) / 3u;
}

// Whether a tether that rested on `before` does so on `after`.
fn holds(before: u32, after: u32) -> bool {
  return after == 0u || (after < UNSUPPORTED && after == before);
}

// Whether there is a tether that can change. Pins hang on themselves.
fn hangs(tether: vec2<u32>) -> bool {
  return tether.x != NONE && bitcast<f32>(tether.y) > 0.0;
}

fn ended(tether: vec2<u32>) -> vec2<u32> {
  return vec2<u32>(tether.x, bitcast<u32>(FAR));
}

// A tether of a texel after a round.
fn changed(phase: u32, k: u32, t: u32) -> vec2<u32> {
  let was = tethers[t];
  let group = supports[2u * t];
  let before = supports[2u * t + 1u];
  if (!hangs(was)) {
    return was;
  }
  if (phase == 1u) {
    if (bitcast<f32>(was.y) < FAR && !holds(before, support(k, was, group))) {
      return ended(was);
    }
  } else if (before == LOST) {
    let way = nearest(k, group);
    if (way.y < bitcast<u32>(FAR)) {
      return shorter(was, way);
    }
  }
  return was;
}

fn find(phase: u32, k: u32, place: u32) {
  for (var s = 0u; s < slots; s++) {
    holding[place * slots + s] = changed(phase, k, k * slots + s);
  }
}

// Takes the tethers that were found, and puts the texels beside a change into a list.
fn settle(phase: u32, k: u32, place: u32, list: u32, round: u32) {
  var any_changed = false;
  for (var s = 0u; s < slots; s++) {
    let t = k * slots + s;
    let found = holding[place * slots + s];
    if (any(found != tethers[t])) {
      any_changed = true;
      tethers[t] = found;
      if (phase == 1u) {
        supports[2u * t + 1u] = LOST;
      }
    }
  }
  if (any_changed) {
    list_around(k, list, round);
  }
}

// Texels around one and at the other ends of its stitches, and their duplicates, each once per round. The duplicates of this one do the same.
fn list_around(k: u32, list: u32, round: u32) {
  let grid = grid_of(k);
  for (var c = 0u; c < 8u; c++) {
    list_ring(beside(grid, k, c), list, round);
  }
  let last = bridges_from(k + 1u);
  for (var e = bridges_from(k); e < last; e++) {
    list_ring(bridge_to(e), list, round);
  }
}

fn list_ring(n: u32, list: u32, round: u32) {
  var m = n;
  for (var start = true; start || m != n; start = false) {
    if (atomicMax(&changes[STAMPS + m], round) < round) {
      let place = atomicAdd(&changes[list], 1u);
      atomicStore(&changes[STAMPS + (1u + list) * texels() + place], m);
    }
    m = mate(m);
  }
}

fn listed(list: u32, place: u32) -> u32 {
  return atomicLoad(&changes[STAMPS + (1u + list) * texels() + place]);
}

// Makes rounds until nothing changes, within the limits on rounds and on texels per thread. If the last walk of phase 1 does not
// come to its end, all tethers end.
fn walk(local: u32) {
  let phase = u32(action[0].x);
  let rounds = u32(action[0].y);
  let most = u32(action[0].z);
  let last = action[0].w != 0.0;
  var list = atomicLoad(&changes[TURN]);
  var round = atomicLoad(&changes[ROUND]) + 1u;
  var spent = 0u;
  var more = true;
  for (var n = 0u; n < rounds && more; n++) {
    if (local == 0u) {
      shared_count = atomicLoad(&changes[list]);
    }
    let count = workgroupUniformLoad(&shared_count);
    let turns = (count + GROUP - 1u) / GROUP;
    more = count > 0u && (spent == 0u || spent + turns <= most);
    if (more) {
      spent += turns;
      round += 1u;
      for (var e = local; e < count; e += GROUP) {
        find(phase, listed(list, e), e);
      }
    }
    storageBarrier();
    if (more) {
      for (var e = local; e < count; e += GROUP) {
        settle(phase, listed(list, e), e, 1u - list, round);
      }
    }
    storageBarrier();
    if (more) {
      if (local == 0u) {
        atomicStore(&changes[list], 0u);
      }
      list = 1u - list;
    }
    storageBarrier();
  }
  let unfinished = atomicLoad(&changes[list]) > 0u;
  if (last && phase == 1u && unfinished) {
    for (var t = local; t < arrayLength(&tethers); t += GROUP) {
      if (hangs(tethers[t])) {
        tethers[t] = ended(tethers[t]);
        supports[2u * t + 1u] = LOST;
      }
    }
  }
  storageBarrier();
  if (local == 0u) {
    atomicStore(&changes[TURN], select(list, 0u, last));
    atomicStore(&changes[ROUND], round);
    if (last) {
      atomicStore(&changes[0], 0u);
      atomicStore(&changes[1], 0u);
    }
  }
}

fn one_stage(stage: u32, k: u32) {
  let round = atomicLoad(&changes[ROUND]) + 1u;
  if (stage == 0u) {
    atomicStore(&changes[STAMPS + k], 0u);
    for (var s = 0u; s < slots; s++) {
      let t = k * slots + s;
      if (hangs(tethers[t])) {
        let lost = bitcast<f32>(tethers[t].y) >= FAR;
        supports[2u * t + 1u] = select(support(k, tethers[t], supports[2u * t]), LOST, lost);
      }
    }
  } else if (stage == 1u || stage == 3u) {
    find((stage + 1u) / 2u, k, k);
  } else {
    settle(stage / 2u, k, k, 0u, round);
  }
}

@compute @workgroup_size(threads_x, threads_y)
fn main(@builtin(global_invocation_id) id: vec3<u32>, @builtin(local_invocation_index) local: u32) {
  if (walks) {
    walk(local);
  } else {
    let stage = u32(action[0].x);
    if (stage == 0u && all(id == vec3<u32>(0u))) {
      for (var n = 0u; n < STAMPS; n++) {
        atomicStore(&changes[n], 0u);
      }
    }
    let grid = grids[id.z];
    if (id.x < grid.width && id.y < grid.height) {
      one_stage(stage, grid.first + id.y * grid.width + id.x);
    }
  }
}
