// The nearest point of a surface, found by walking from triangle to triangle.
struct Spot {
  weights: vec3<f32>,
  // The squared distance in square metres.
  far2: f32,
  triangle: u32,
  // 0 inside of the triangle, 1 to 3 on a side, 4 to 6 at a corner.
  on: u32,
}

struct Corners {
  a: vec3<f32>,
  b: vec3<f32>,
  c: vec3<f32>,
}

// The time in the frame at which places are asked for, 0 at its start and 1 at its end.
var<private> time: f32 = 0.0;

// A place that goes evenly from its start to its end, at that time.
fn at_time(start: vec3<f32>, end: vec3<f32>) -> vec3<f32> {
  return start * (1.0 - time) + end * time;
}

fn corners_of(triangle: u32) -> Corners {
  let own = surface_triangles[2u * triangle];
  if (time > 0.0) {
    return Corners(
      at_time(start_of(own.x), end_of(own.x)),
      at_time(start_of(own.y), end_of(own.y)),
      at_time(start_of(own.z), end_of(own.z)),
    );
  }
  return Corners(start_of(own.x), start_of(own.y), start_of(own.z));
}

fn spot_at(p: vec3<f32>, triangle: u32, t: Corners, weights: vec3<f32>, on: u32) -> Spot {
  let d = p - (t.a * weights.x + t.b * weights.y + t.c * weights.z);
  return Spot(weights, dot(d, d), triangle, on);
}

// The point of a triangle that is nearest to `p`: C. Ericson, "Real-Time Collision Detection", 2005, section 5.1.5.
fn on_triangle(p: vec3<f32>, triangle: u32) -> Spot {
  let t = corners_of(triangle);
  let ab = t.b - t.a;
  let ac = t.c - t.a;
  let ap = p - t.a;
  let d1 = dot(ab, ap);
  let d2 = dot(ac, ap);
  if (d1 <= 0.0 && d2 <= 0.0) {
    return spot_at(p, triangle, t, vec3<f32>(1.0, 0.0, 0.0), 4u);
  }
  let bp = p - t.b;
  let d3 = dot(ab, bp);
  let d4 = dot(ac, bp);
  if (d3 >= 0.0 && d4 <= d3) {
    return spot_at(p, triangle, t, vec3<f32>(0.0, 1.0, 0.0), 5u);
  }
  let vc = d1 * d4 - d3 * d2;
  if (vc <= 0.0 && d1 >= 0.0 && d3 <= 0.0) {
    let v = d1 / (d1 - d3);
    return spot_at(p, triangle, t, vec3<f32>(1.0 - v, v, 0.0), 1u);
  }
  let cp = p - t.c;
  let d5 = dot(ab, cp);
  let d6 = dot(ac, cp);
  if (d6 >= 0.0 && d5 <= d6) {
    return spot_at(p, triangle, t, vec3<f32>(0.0, 0.0, 1.0), 6u);
  }
  let vb = d5 * d2 - d1 * d6;
  if (vb <= 0.0 && d2 >= 0.0 && d6 <= 0.0) {
    let w = d2 / (d2 - d6);
    return spot_at(p, triangle, t, vec3<f32>(1.0 - w, 0.0, w), 3u);
  }
  let va = d3 * d6 - d5 * d4;
  if (va <= 0.0 && d4 - d3 >= 0.0 && d5 - d6 >= 0.0) {
    let w = (d4 - d3) / ((d4 - d3) + (d5 - d6));
    return spot_at(p, triangle, t, vec3<f32>(0.0, 1.0 - w, w), 2u);
  }
  let all = 1.0 / (va + vb + vc);
  let v = vb * all;
  let w = vc * all;
  return spot_at(p, triangle, t, vec3<f32>(1.0 - v - w, v, w), 0u);
}

fn direction(v: vec3<f32>) -> vec3<f32> {
  let length = sqrt(dot(v, v));
  return select(v, v * (1.0 / length), length > 1e-18);
}

// Whether a triangle faces away from a normal.
fn faces_away(triangle: u32, normal: vec3<f32>) -> bool {
  let t = corners_of(triangle);
  return dot(normal, direction(cross(t.b - t.a, t.c - t.a))) < SECOND_COSINE;
}

// The nearest of the triangles beyond the sides in `mask`, if it is nearer and faces away from a normal.
fn beyond(spot: Spot, mask: u32, p: vec3<f32>, away: vec3<f32>) -> Spot {
  let across = surface_triangles[2u * spot.triangle + 1u];
  var best = spot;
  for (var side = 0u; side < 3u; side++) {
    let other = across[side];
    if ((mask >> side & 1u) == 1u && other != NO_TRIANGLE) {
      let found = on_triangle(p, other);
      if (found.far2 < best.far2 && faces_away(other, away)) {
        best = found;
      }
    }
  }
  return best;
}

// The sides of a face that hide a triangle beyond them: where the surface is hollow, and from behind.
fn hiding(spot: Spot, p: vec3<f32>) -> u32 {
  let t = corners_of(spot.triangle);
  let behind = dot(p - t.a, cross(t.b - t.a, t.c - t.a)) < 0.0;
  return select(surface_triangles[2u * spot.triangle].w & 7u, 7u, behind);
}

// The nearest triangle around a corner, if it is nearer and faces away from a normal: one way round, and the other way too if that ends at a border.
fn around(spot: Spot, corner: u32, p: vec3<f32>, away: vec3<f32>) -> Spot {
  let vertex = surface_triangles[2u * spot.triangle][corner];
  var best = spot;
  var closed = false;
  for (var way = 0u; way < 3u && !closed; way += 2u) {
    var at = spot.triangle;
    for (var n = 0u; n < WALK_AROUND; n++) {
      let own = surface_triangles[2u * at].xyz;
      let c = select(select(2u, 1u, own.y == vertex), 0u, own.x == vertex);
      let next = surface_triangles[2u * at + 1u][(c + way) % 3u];
      if (next == NO_TRIANGLE || next == spot.triangle) {
        closed = next != NO_TRIANGLE;
        break;
      }
      at = next;
      let found = on_triangle(p, at);
      if (found.far2 < best.far2 && faces_away(at, away)) {
        best = found;
      }
    }
  }
  return best;
}

// The nearest point to `p` that a walk from a triangle finds: each step goes to a neighbour that is nearer.
fn walk(start: u32, p: vec3<f32>) -> Spot {
  return walk_beyond(start, p, vec3<f32>(0.0));
}

// The same among triangles that face away from a normal: so a walk on one wall of a crease does not come out on the other one. All face away from 0.
fn walk_beyond(start: u32, p: vec3<f32>, away: vec3<f32>) -> Spot {
  var spot = on_triangle(p, start);
  for (var n = 0u; n < WALK_STEPS; n++) {
    var next = spot;
    if (spot.on == 0u) {
      next = beyond(spot, hiding(spot, p), p, away);
    } else if (spot.on <= 3u) {
      next = beyond(spot, 1u << (spot.on - 1u), p, away);
    } else {
      next = around(spot, spot.on - 4u, p, away);
    }
    if (next.triangle == spot.triangle) {
      break;
    }
    spot = next;
  }
  return spot;
}
