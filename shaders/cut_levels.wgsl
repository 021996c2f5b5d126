// After a cut the coarser grids are rebuilt from the springs that are left: limits, which nodes everything follows, and
// the masses of nodes. One workgroup a grid, from the finest level to the coarsest.
@group(0) @binding(21) var<storage, read_write> nodes: array<vec4<f32>>;
@group(0) @binding(22) var<storage, read_write> limits: array<vec4<f32>>;
// As in part/links.wgsl.
struct Link {
  follows: u32,
  mass: f32,
}
@group(0) @binding(42) var<storage, read_write> links: array<Link>;

const GROUP: u32 = 256u;

// Where the links of nodes begin, behind those of particles.
fn links_of_nodes() -> u32 {
  return arrayLength(&links) - arrayLength(&nodes) / 2u;
}

// The grid that a level is made of.
struct Below {
  first: u32,
  links: u32,
  size: vec2<i32>,
  fine: bool,
}

// Rest length or limit of the spring that is stored at a place; 0 is none.
fn limit(b: Below, x: i32, y: i32, d: u32) -> f32 {
  let right = i32(d != 1u);
  let down = select(i32(d != 0u), -1, d == 3u);
  let end = vec2<i32>(x + right, y + down);
  if (x < 0 || y < 0 || y >= b.size.y || end.x >= b.size.x || end.y < 0 || end.y >= b.size.y) {
    return 0.0;
  }
  let k = u32(y * b.size.x + x);
  if (!b.fine) {
    return limits[b.first + k][d];
  }
  let other = u32(end.y * b.size.x + end.x);
  let there = links[b.links + k].mass > 0.0 && links[b.links + other].mass > 0.0;
  return select(0.0, rest[b.first + k][d], there);
}

// Along two springs, one after the other; 0 if either is not there.
fn path(a: f32, b: f32) -> f32 {
  return select(0.0, a + b, a > 0.0 && b > 0.0);
}

fn shorter(a: f32, b: f32) -> f32 {
  return select(max(a, b), min(a, b), a > 0.0 && b > 0.0);
}

fn along(b: Below, x: i32, y: i32, steps: i32, d: u32) -> f32 {
  if (steps == 0) {
    return 0.0;
  }
  if (steps == 1) {
    return limit(b, x, y, d);
  }
  return path(limit(b, x, y, d), limit(b, x + i32(d == 0u), y + i32(d == 1u), d));
}

// Down-right or up-right over `right` columns and `rows` rows.
fn across(b: Below, x: i32, y: i32, right: i32, rows: i32, down: bool) -> f32 {
  let d = select(3u, 2u, down);
  let step = select(-1, 1, down);
  // A spring down is stored at its upper end.
  let fall = select(-1, 0, down);
  if (right == 0 || rows == 0) {
    return 0.0;
  }
  let first = limit(b, x, y, d);
  if (right == 1 && rows == 1) {
    return first;
  }
  if (rows == 1) {
    return shorter(path(first, limit(b, x + 1, y + step, 0u)), path(limit(b, x, y, 0u), limit(b, x + 1, y, d)));
  }
  if (right == 1) {
    let after = limit(b, x + 1, y + step + fall, 1u);
    return shorter(path(first, after), path(limit(b, x, y + fall, 1u), limit(b, x, y + step, d)));
  }
  return path(first, limit(b, x + 1, y + step, d));
}

// Whether there is a spring from a place by one step.
fn joined(b: Below, x: i32, y: i32, dx: i32, dy: i32) -> bool {
  // Springs are stored at their left end, those down at their upper one.
  let back = dx < 0 || (dx == 0 && dy < 0);
  let at = select(vec2<i32>(x, y), vec2<i32>(x + dx, y + dy), back);
  let by = select(vec2<i32>(dx, dy), vec2<i32>(-dx, -dy), back);
  var d = 3u;
  if (by.y == 0) {
    d = 0u;
  } else if (by.x == 0) {
    d = 1u;
  } else if (by.y == 1) {
    d = 2u;
  }
  return limit(b, at.x, at.y, d) > 0.0;
}

// Whether springs lead from a place to a neighbour, three at most.
fn reaches(b: Below, x: i32, y: i32, dx: i32, dy: i32) -> bool {
  if ((dx == 0 && dy == 0) || joined(b, x, y, dx, dy)) {
    return true;
  }
  if (dx != 0 && dy != 0) {
    return (joined(b, x, y, dx, 0) && joined(b, x + dx, y, 0, dy))
      || (joined(b, x, y, 0, dy) && joined(b, x, y + dy, dx, 0));
  }
  // By way of the cells on either side.
  for (var s = -1; s < 2; s += 2) {
    let px = s * dy;
    let py = s * dx;
    let here = joined(b, x, y, px, py);
    let there = joined(b, x + dx, y + dy, px, py);
    if ((here && joined(b, x + px, y + py, dx - px, dy - py))
      || (there && joined(b, x, y, dx + px, dy + py))
      || (here && there && joined(b, x + px, y + py, dx, dy))) {
      return true;
    }
  }
  return false;
}

// The column (or row) of the grid below in which a node lies.
fn column(n: i32, size: i32) -> i32 {
  return min(2 * n, size - 1);
}

// Which of the nodes around it a place of the grid below follows.
fn follows(b: Below, x: i32, y: i32) -> u32 {
  let columns = vec2<i32>(nodes_around(u32(x), u32(b.size.x)));
  let rows = vec2<i32>(nodes_around(u32(y), u32(b.size.y)));
  var bits = 0u;
  for (var n = 0u; n < 4u; n++) {
    let dx = column(columns[n & 1u], b.size.x) - x;
    let dy = column(rows[n >> 1u], b.size.y) - y;
    bits |= u32(reaches(b, x, y, dx, dy)) << n;
  }
  return bits;
}

// The mass of what follows node (i, j), each in the share that it takes of the node's displacement.
fn mass(b: Below, i: i32, j: i32) -> f32 {
  let x = column(i, b.size.x);
  let y = column(j, b.size.y);
  var sum = 0.0;
  for (var row = max(y - 1, 0); row <= min(y + 1, b.size.y - 1); row++) {
    for (var col = max(x - 1, 0); col <= min(x + 1, b.size.x - 1); col++) {
      let link = links[b.links + u32(row * b.size.x + col)];
      let columns = nodes_around(u32(col), u32(b.size.x)) == vec2<u32>(u32(i));
      let rows = nodes_around(u32(row), u32(b.size.y)) == vec2<u32>(u32(j));
      let here = select(0u, 5u, columns.x) | select(0u, 10u, columns.y);
      let at = here & (select(0u, 3u, rows.x) | select(0u, 12u, rows.y)) & link.follows;
      sum += link.mass * (f32(countOneBits(at)) / f32(max(countOneBits(link.follows), 1u)));
    }
  }
  return sum;
}

fn make(local: u32, b: Below, level: Level) {
  for (var n = local; n < level.width * level.height; n += GROUP) {
    let i = i32(n % level.width);
    let j = i32(n / level.width);
    let x = column(i, b.size.x);
    let y = column(j, b.size.y);
    // One or two springs to the next node.
    let right = column(i + 1, b.size.x) - x;
    let down = column(j + 1, b.size.y) - y;
    let up = y - column(max(j - 1, 0), b.size.y);
    limits[level.first + n] = vec4<f32>(
      along(b, x, y, right, 0u),
      along(b, x, y, down, 1u),
      across(b, x, y, right, down, true),
      across(b, x, y, right, up, false));
    let m = mass(b, i, j);
    links[links_of_nodes() + level.image + n].mass = m;
    // A node that could not move stays so.
    let at = 2u * (level.first + n) + 1u;
    nodes[at].w = select(0.0, 1.0 / max(m, 1e-30), m > 0.0 && nodes[at].w > 0.0);
  }
}

@compute @workgroup_size(256)
fn main(@builtin(workgroup_id) id: vec3<u32>, @builtin(local_invocation_index) local: u32) {
  let grid = grids_at(id.z);
  let head = levels_at(id.z);
  var b = Below(grid.first, grid.first, vec2<i32>(i32(grid.width), i32(grid.height)), true);
  for (var n = 0u; n < head.y; n++) {
    let level = level_at(head.x + n);
    for (var k = local; k < u32(b.size.x * b.size.y); k += GROUP) {
      links[b.links + k].follows = follows(b, i32(k % u32(b.size.x)), i32(k / u32(b.size.x)));
    }
    storageBarrier();
    make(local, b, level);
    storageBarrier();
    b = Below(level.first, links_of_nodes() + level.image, vec2<i32>(i32(level.width), i32(level.height)), false);
  }
}
