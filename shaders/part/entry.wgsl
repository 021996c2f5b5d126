// Where a path enters a solid. See crates/runtime/src/collider/solid/entry.rs.
struct Entry {
  t: f32,
  normal: vec3<f32>,
}

// Past the end of the path: nothing is met.
const NEVER: f32 = 2.0;

fn never() -> Entry {
  return Entry(NEVER, vec3<f32>(0.0));
}

fn enter_ball(o: vec3<f32>, d: vec3<f32>, center: vec3<f32>, radius: f32) -> Entry {
  let m = o - center;
  let a = dot(d, d);
  let b = dot(m, d);
  let c = dot(m, m) - radius * radius;
  let under = b * b - a * c;
  if (c <= 0.0 || b >= 0.0 || a <= 0.0 || under < 0.0) {
    return never();
  }
  let t = (-b - sqrt(under)) / a;
  return Entry(t, normalized(m + d * t));
}

// The side, else one of the caps.
fn enter_capsule(o: vec3<f32>, d: vec3<f32>, radius: f32, half: f32) -> Entry {
  let a = d.x * d.x + d.z * d.z;
  let b = o.x * d.x + o.z * d.z;
  let c = o.x * o.x + o.z * o.z - radius * radius;
  let under = b * b - a * c;
  if (a > 0.0 && c > 0.0 && b < 0.0 && under >= 0.0) {
    let t = (-b - sqrt(under)) / a;
    if (abs(o.y + d.y * t) <= half) {
      return Entry(t, normalized(vec3<f32>(o.x + d.x * t, 0.0, o.z + d.z * t)));
    }
  }
  let top = enter_ball(o, d, vec3<f32>(0.0, half, 0.0), radius);
  let bottom = enter_ball(o, d, vec3<f32>(0.0, -half, 0.0), radius);
  if (top.t < bottom.t) {
    return top;
  }
  return bottom;
}

// The side, else one of the balls. See crates/runtime/src/collider/solid/taper.rs.
fn enter_tapered(o: vec3<f32>, d: vec3<f32>, size: vec3<f32>) -> Entry {
  let cone = taper(size);
  let square = cone.across * cone.across;
  let to = cone.middle - cone.along * o.y;
  let by = cone.along * d.y;
  let a = square * (d.x * d.x + d.z * d.z) - by * by;
  let b = square * (o.x * d.x + o.z * d.z) + to * by;
  let c = square * (o.x * o.x + o.z * o.z) - to * to;
  let under = b * b - a * c;
  let rest = sqrt(max(under, 0.0)) - b;
  if (under >= 0.0 && rest != 0.0) {
    let t = c / rest;
    let left = to - by * t;
    let at = o + d * t;
    let y = at.y - cone.along * left / square;
    if (t >= 0.0 && left > 0.0 && abs(y) <= cone.half) {
      let beside = cone.across / sqrt(at.x * at.x + at.z * at.z);
      return Entry(t, normalized(vec3<f32>(at.x * beside, cone.along, at.z * beside)));
    }
  }
  let top = enter_ball(o, d, vec3<f32>(0.0, size.y, 0.0), size.z);
  let bottom = enter_ball(o, d, vec3<f32>(0.0, -size.y, 0.0), size.x);
  if (top.t < bottom.t) {
    return top;
  }
  return bottom;
}

// By slabs.
fn enter_box(o: vec3<f32>, d: vec3<f32>, half: vec3<f32>) -> Entry {
  var first = -1e30;
  var last = 1e30;
  var normal = vec3<f32>(0.0);
  for (var c = 0u; c < 3u; c++) {
    if (d[c] == 0.0) {
      if (abs(o[c]) > half[c]) {
        return never();
      }
      continue;
    }
    let a = (-half[c] - o[c]) / d[c];
    let b = (half[c] - o[c]) / d[c];
    if (min(a, b) > first) {
      first = min(a, b);
      normal = vec3<f32>(0.0);
      normal[c] = select(1.0, -1.0, d[c] > 0.0);
    }
    last = min(last, max(a, b));
  }
  if (first > last || first < 0.0) {
    return never();
  }
  return Entry(first, normal);
}

fn enter(solid: Solid, start: vec3<f32>, path: vec3<f32>) -> Entry {
  let back = vec4<f32>(-solid.rotation.xyz, solid.rotation.w);
  let o = turned(back, start - solid.center);
  let d = turned(back, path);
  var hit = never();
  if (spheres && solid.kind == 1u) {
    hit = enter_ball(o, d, vec3<f32>(0.0), solid.size.x);
  } else if (capsules && solid.kind == 2u) {
    hit = enter_capsule(o, d, solid.size.x, solid.size.y);
  } else if (tapered_capsules && solid.kind == 6u) {
    hit = enter_tapered(o, d, solid.size);
  } else if (boxes && solid.kind == 3u) {
    hit = enter_box(o, d, solid.size);
  } else if ((radial_ellipsoids || ellipsoids) && solid.kind >= 4u) {
    hit = enter_ball(o / solid.size, d / solid.size, vec3<f32>(0.0), 1.0);
    hit.normal = normalized(hit.normal / solid.size);
  }
  return Entry(hit.t, turned(solid.rotation, hit.normal));
}

// The smallest distance through the middle; a half-space has no other side.
fn thickness(solid: Solid) -> f32 {
  if (solid.kind == 0u) {
    return 1e18;
  }
  if (solid.kind <= 2u) {
    return solid.size.x;
  }
  if (tapered_capsules && solid.kind == 6u) {
    return min(solid.size.x, solid.size.z);
  }
  return min(solid.size.x, min(solid.size.y, solid.size.z));
}
