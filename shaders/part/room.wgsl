// The room of a particle in a round: half-spaces, of which it keeps MAX_PLANES, four by four.
var<private> room_way: vec3<f32>;
// The radius of the ball around the middle of its way in which it stays, and rounding of a position.
var<private> room_radius: f32;
var<private> room_slop: f32;
// By how much less room two half-spaces may leave that become one.
var<private> room_merges: f32;
var<private> room_still: bool;
var<private> plane_count: u32;
var<private> plane_x: array<vec4<f32>, PLANE_GROUPS>;
var<private> plane_y: array<vec4<f32>, PLANE_GROUPS>;
var<private> plane_z: array<vec4<f32>, PLANE_GROUPS>;
var<private> plane_most: array<vec4<f32>, PLANE_GROUPS>;

fn begin_room(base: vec4<f32>, way: vec3<f32>, spacing: f32) {
  room_way = way;
  room_radius = base.w;
  room_slop = max(largest(base.xyz), largest(way)) * HELD_ROUNDING;
  room_merges = spacing * MERGES_SHARE;
  for (var g = 0u; g < PLANE_GROUPS; g++) {
    plane_most[g] = vec4<f32>(FARTHEST);
  }
}

// Adds a half-space. If it nearly equals another one, or the list is full, the other one shrinks until it implies both.
fn add_plane(normal: vec3<f32>, most: f32) {
  let far = 0.5 * sqrt(dot(room_way, room_way)) + room_radius;
  var best = 0u;
  var loss = FARTHEST;
  var least = 0.0;
  for (var g = 0u; g < PLANE_GROUPS; g++) {
    let x = normal.x - plane_x[g];
    let y = normal.y - plane_y[g];
    let z = normal.z - plane_z[g];
    let within = most - sqrt(x * x + y * y + z * z) * far;
    let losses = plane_most[g] - within;
    for (var n = 0u; n < 4u; n++) {
      let first = losses[n] < loss && 4u * g + n < plane_count;
      best = select(best, 4u * g + n, first);
      least = select(least, within[n], first);
      loss = select(loss, losses[n], first);
    }
  }
  if (loss > room_merges && plane_count < 4u * PLANE_GROUPS) {
    plane_x[plane_count / 4u][plane_count % 4u] = normal.x;
    plane_y[plane_count / 4u][plane_count % 4u] = normal.y;
    plane_z[plane_count / 4u][plane_count % 4u] = normal.z;
    plane_most[plane_count / 4u][plane_count % 4u] = most;
    plane_count += 1u;
  } else {
    plane_most[best / 4u][best % 4u] = min(plane_most[best / 4u][best % 4u], least);
  }
}

// Takes in what keeps the particle apart from a feature.
fn take(bound: Bound) {
  room_still = room_still || bound.kind == STILL;
  // All of its ball may lie in it.
  if (bound.kind == PLANE && 0.5 * dot(bound.normal, room_way) + room_radius > bound.most) {
    add_plane(bound.normal, bound.most);
  }
}

fn has_room(way: vec3<f32>) -> bool {
  let off = way - room_way * 0.5;
  var inside = !room_still && dot(off, off) <= room_radius * room_radius;
  for (var g = 0u; g < PLANE_GROUPS; g++) {
    inside = inside && all(plane_x[g] * way.x + plane_y[g] * way.y + plane_z[g] * way.z <= plane_most[g]);
  }
  return inside;
}

fn plane_at(n: u32) -> vec4<f32> {
  let g = n / 4u;
  let c = n % 4u;
  return vec4<f32>(plane_x[g][c], plane_y[g][c], plane_z[g][c], plane_most[g][c]);
}

// The nearest way that is, after some rounds, nearly in all half-spaces.
fn project() -> vec3<f32> {
  let half = room_way * 0.5;
  let radius = room_radius - room_slop;
  var way = room_way;
  for (var round = 0u; round < PROJECTIONS; round++) {
    for (var n = 0u; n < plane_count; n++) {
      let plane = plane_at(n);
      let over = dot(plane.xyz, way) - plane.w;
      way -= plane.xyz * select(0.0, over + room_slop, over > 0.0);
    }
    let off = way - half;
    let long = sqrt(dot(off, off));
    way = select(way, half + off * (radius / max(long, 1e-37)), long > radius);
  }
  return way;
}

// The position nearest to the end of a way that the room has.
fn clip(base: vec3<f32>, way: vec3<f32>) -> vec3<f32> {
  var share = 1.0;
  for (var n = 0u; n < plane_count; n++) {
    let plane = plane_at(n);
    let end = dot(plane.xyz, way);
    let part = max((plane.w - room_slop) / max(end, 1e-37), 0.0);
    share = select(share, min(share, part), end > plane.w - room_slop && end > 0.0);
  }
  var found = base;
  var going = true;
  var next = 1.0;
  for (var n = 0u; n <= HALVINGS && going; n++) {
    let p = base + way * next;
    going = !has_room(p - base);
    found = select(p, found, going);
    next = share;
    share *= 0.5;
  }
  return found;
}
