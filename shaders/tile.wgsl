// Several passes of a step, by tiles: a workgroup has a part of a grid in its memory, with so much around it that what it
// owns comes out as if the whole cloth had gone through the passes one by one. It writes what it owns, to another place, as
// its neighbours read what is around theirs. `arrive_program`, `middle_program` and `leave_program` are made from the list of passes.
@group(0) @binding(2) var<storage, read> now: array<vec4<f32>>;
@group(0) @binding(34) var<storage, read_write> next: array<vec4<f32>>;

override threads: u32 = 64u;
// Particles that the memory has room for, and those of a row there.
override places: u32 = 64u;
override stride: u32 = 8u;
// Columns and rows that a tile owns, those around them on every side, and those that the first tile lacks.
override inner_x: u32 = 8u;
override inner_y: u32 = 8u;
override around_x: u32 = 0u;
override around_y: u32 = 0u;
override lacks_x: u32 = 0u;
override lacks_y: u32 = 0u;
// Whether particles are still being taken in, and whether the tile owns the one at hand.
var<private> arriving: bool;
var<private> own: bool;

var<workgroup> held: array<vec4<f32>, places>;

// The grid, the tile's corner on it, and where that particle is in the list.
var<private> grid: u32;
var<private> size: vec2<u32>;
var<private> corner: vec2<u32>;
var<private> start: u32;
// Particles that the tile owns, and those of its memory that are right so far: from low up to, not with, high.
var<private> own_low: vec2<u32>;
var<private> own_high: vec2<u32>;
var<private> low: vec2<u32>;
var<private> high: vec2<u32>;
// Where the row that a spring begins in has its first particle, in the list and in the memory.
var<private> upper: u32;
var<private> upper_place: u32;

// Of a particle in that row or the next.
fn place_of(k: u32) -> u32 {
  let n = k - upper;
  return upper_place + select(n, n - size.x + stride, n >= size.x);
}

fn place(k: u32) -> vec4<f32> {
  return held[place_of(k)];
}

fn put(k: u32, p: vec4<f32>) {
  held[place_of(k)] = p;
}

// Columns (at least 1) and rows that the tile owns.
fn own_columns() -> u32 {
  return max(select(0u, own_high.x - own_low.x, all(own_low < own_high)), 1u);
}

fn own_rows() -> u32 {
  return select(0u, own_high.y - own_low.y, all(own_low < own_high));
}

// From here on `place` and `put` are of this row and the next.
fn to_row(y: u32) {
  upper = start + (y - corner.y) * size.x;
  upper_place = (y - corner.y) * stride;
}

// The particle of a cell, whose row `place` and `put` are of from here on.
fn here(cell: vec2<u32>) -> u32 {
  to_row(cell.y);
  return listed(cell);
}

fn listed(cell: vec2<u32>) -> u32 {
  return start + (cell.y - corner.y) * size.x + cell.x - corner.x;
}

fn stored(cell: vec2<u32>) -> u32 {
  return (cell.y - corner.y) * stride + cell.x - corner.x;
}

@compute @workgroup_size(threads)
fn main(@builtin(workgroup_id) workgroup: vec3<u32>, @builtin(local_invocation_index) local: u32) {
  let inner = vec2<u32>(inner_x, inner_y);
  let around = vec2<u32>(around_x, around_y);
  let lacks = vec2<u32>(lacks_x, lacks_y);
  size = take_grid(workgroup.z, all(workgroup.xy == vec2<u32>(0u)) && local == 0u);
  own_low = min(max(workgroup.xy * inner, lacks) - lacks, size);
  own_high = min((workgroup.xy + 1u) * inner - lacks, size);
  low = max(own_low, around) - around;
  // Cloth may have grids that end before the tile begins.
  high = select(low, min(own_high + around, size), all(own_low < own_high));
  corner = low;
  start = grids_at(grid).first + low.y * size.x + low.x;

  let columns = max(high.x - low.x, 1u);
  let by = by_rows(threads, columns);
  var cell = by_rows(local, columns);
  arriving = true;
  end_last_step(local);
  while (cell.y < high.y - low.y) {
    let at = low + cell;
    let k = here(at);
    let p = taken(k);
    own = all(at >= own_low) && all(at < own_high);
    take_sums(k, stored(at));
    if (p.w <= 0.0) {
      stay(k);
    }
    arrive(k);
    cell = on_by_rows(cell, by, columns);
  }
  arriving = false;
  workgroupBarrier();
  middle_program(local);
  leave_program(local);
  end_step();
  let own_by = by_rows(threads, own_columns());
  cell = by_rows(local, own_columns());
  while (cell.y < own_rows()) {
    let at = own_low + cell;
    let k = here(at);
    depart(k);
    next[k] = held[stored(at)];
    give_sums(k, stored(at));
    cell = on_by_rows(cell, own_by, own_columns());
  }
}
