// The half-space that keeps a particle, of one of two features, on its side: crates/runtime/src/cpu/joint/planes.rs. All numbers are differences
// to a particle of the pair.

// A half-space: its normal, and the farthest that the way of the particle goes along it. Nothing keeps features apart that cross or touch.
const FREE: u32 = 0u;
const PLANE: u32 = 1u;
const STILL: u32 = 2u;
struct Bound {
  kind: u32,
  normal: vec3<f32>,
  most: f32,
}

// From 0 to the closest point of a triangle (C. Ericson, "Real-Time Collision Detection", 2005, section 5.1).
fn to_triangle(a: vec3<f32>, b: vec3<f32>, c: vec3<f32>) -> vec3<f32> {
  let ab = b - a;
  let ac = c - a;
  let d1 = -dot(ab, a);
  let d2 = -dot(ac, a);
  if (d1 <= 0.0 && d2 <= 0.0) {
    return a;
  }
  let d3 = -dot(ab, b);
  let d4 = -dot(ac, b);
  if (d3 >= 0.0 && d4 <= d3) {
    return b;
  }
  let vc = d1 * d4 - d3 * d2;
  if (vc <= 0.0 && d1 >= 0.0 && d3 <= 0.0 && d1 > d3) {
    return a + ab * (d1 / (d1 - d3));
  }
  let d5 = -dot(ab, c);
  let d6 = -dot(ac, c);
  if (d6 >= 0.0 && d5 <= d6) {
    return c;
  }
  let vb = d5 * d2 - d1 * d6;
  if (vb <= 0.0 && d2 >= 0.0 && d6 <= 0.0 && d2 > d6) {
    return a + ac * (d2 / (d2 - d6));
  }
  let va = d3 * d6 - d5 * d4;
  let e = d4 - d3;
  let f = d5 - d6;
  if (va <= 0.0 && e >= 0.0 && f >= 0.0 && e + f > 0.0) {
    return b + (c - b) * (e / (e + f));
  }
  let normal = cross(ab, ac);
  let square = dot(normal, normal);
  return select(a, normal * (dot(a, normal) / max(square, 1e-37)), square > 0.0);
}

// From an edge that begins at 0 to the closest point of another one.
fn to_edge(q1: vec3<f32>, p2: vec3<f32>, q2: vec3<f32>) -> vec3<f32> {
  let d2 = q2 - p2;
  let a = dot(q1, q1);
  let e = dot(d2, d2);
  let f = -dot(d2, p2);
  let c = -dot(q1, p2);
  let b = dot(q1, d2);
  let denominator = a * e - b * b;
  // Of edges that are nearly parallel any point will do.
  let crosses = denominator > 1e-6 * a * e;
  var s = select(0.0, clamp((b * f - c * e) / max(denominator, 1e-37), 0.0, 1.0), crosses);
  var t = select(0.0, (b * s + f) / max(e, 1e-37), e > 0.0);
  if (t < 0.0 || t > 1.0) {
    t = clamp(t, 0.0, 1.0);
    s = select(0.0, clamp((b * t - c) / max(a, 1e-37), 0.0, 1.0), a > 0.0);
  }
  return (p2 + d2 * t) - q1 * s;
}

// How far the first of two features reaches along a normal, and where the second one begins. The first one has 0 and, of edges, the second
// particle.
fn sides(normal: vec3<f32>, at: array<vec3<f32>, 4>, edges: bool) -> vec2<f32> {
  let heights = vec4<f32>(dot(normal, at[0]), dot(normal, at[1]), dot(normal, at[2]), dot(normal, at[3]));
  let high = select(heights.x, max(heights.x, heights.y), edges);
  let low = min(heights.z, heights.w);
  return vec2<f32>(high, select(min(heights.y, low), low, edges));
}

// The bound that keeps the particle `who` of four on its side in a round: two edges of two, or a vertex and a triangle. `gap_least`: least gap.
fn bound_of(four: vec4<u32>, edges: bool, who: u32, gap_least: f32) -> Bound {
  let origin = bases[four.x].xyz;
  var at = array<vec3<f32>, 4>(
    vec3<f32>(0.0), bases[four.y].xyz - origin, bases[four.z].xyz - origin, bases[four.w].xyz - origin);
  let size = sqrt(max(dot(at[1], at[1]), max(dot(at[2], at[2]), dot(at[3], at[3]))));
  var way = vec3<f32>(0.0);
  if (edges) {
    way = to_edge(at[1], at[2], at[3]);
  } else {
    way = to_triangle(at[1], at[2], at[3]);
  }
  let far = sqrt(dot(way, way));
  if (far <= size * TOUCH) {
    return Bound(FREE, vec3<f32>(0.0), 0.0);
  }
  var normal = way * (1.0 / far);
  var side = sides(normal, at, edges);
  if (side.y - side.x < 0.5 * far) {
    // Rounding may turn a short way; the normal of both edges, or of the triangle, is better then.
    var other = cross(at[2] - at[1], at[3] - at[1]);
    if (edges) {
      other = cross(at[1], at[3] - at[2]);
    }
    let long = sqrt(dot(other, other));
    other = other * (select(1.0, -1.0, dot(other, at[2]) < 0.0) / max(long, 1e-37));
    let found = sides(other, at, edges);
    if (long > 0.0 && found.y - found.x > side.y - side.x) {
      normal = other;
      side = found;
    }
  }
  let gap = side.y - side.x;
  if (gap <= size * TOUCH) {
    return Bound(STILL, vec3<f32>(0.0), 0.0);
  }
  let slack = gap - min(gap, max(gap_least, (1.0 - GAP_SHARE) * gap));
  // The side that moves towards the other gets more of it; a pin all that it needs.
  var moves = vec2<f32>(0.0);
  var must = vec2<f32>(0.0);
  for (var n = 0u; n < 4u; n++) {
    let first = n == 0u || (edges && n == 1u);
    let moving = ways[four[n]];
    let along = dot(normal, moving.xyz);
    let height = dot(normal, at[n]);
    let moved = select(vec2<f32>(0.0, -along), vec2<f32>(along, 0.0), first);
    moves = max(moves, moved);
    if (moving.w <= 0.0) {
      // Another particle of the feature may be the nearest one.
      let needs = select(
        vec2<f32>(0.0, -along - (height - side.y)), vec2<f32>(along - (side.x - height), 0.0), first);
      must = max(must, needs);
    }
  }
  let rest = 0.05 * gap;
  let asked = slack * (moves.x + rest) / (moves.x + moves.y + 2.0 * rest);
  let share = min(min(max(asked, must.x), max(slack - must.y, 0.0)), slack);
  let height = dot(normal, at[who]);
  let room = size * PLANE_ERROR;
  if (who == 0u || (edges && who == 1u)) {
    return Bound(PLANE, normal, side.x + share - height - room);
  }
  return Bound(PLANE, -normal, height - side.y + slack - share - room);
}
