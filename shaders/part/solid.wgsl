// A collider in numbers, and the way out of it. Laid out as `SolidRow` in crates/runtime/src/layout.rs.
struct Solid {
  center: vec3<f32>,
  kind: u32,
  size: vec3<f32>,
  friction: f32,
  rotation: vec4<f32>,
  velocity: vec3<f32>,
  unused1: u32,
  spin: vec3<f32>,
  unused2: u32,
}
@group(0) @binding(7) var<storage, read> solids: array<Solid>;

override half_spaces: bool = true;
override spheres: bool = true;
override capsules: bool = true;
override boxes: bool = true;
override radial_ellipsoids: bool = true;
override ellipsoids: bool = true;
override tapered_capsules: bool = true;

struct Exit {
  inside: bool,
  at: vec3<f32>,
  normal: vec3<f32>,
  depth: f32,
}

fn turned(q: vec4<f32>, v: vec3<f32>) -> vec3<f32> {
  let t = cross(q.xyz, v) * 2.0;
  return v + t * q.w + cross(q.xyz, t);
}

fn outside() -> Exit {
  return Exit(false, vec3<f32>(0.0), vec3<f32>(0.0), 0.0);
}

// Out of a ball around the point that lies `d` from `p`; from its very centre to the side.
fn leave_ball(p: vec3<f32>, d: vec3<f32>, radius: f32, side: vec3<f32>) -> Exit {
  let far2 = dot(d, d);
  if (far2 >= radius * radius) {
    return outside();
  }
  let far = sqrt(far2);
  var n = side;
  if (far > 1e-12) {
    n = d * (1.0 / far);
  }
  let depth = radius - far;
  return Exit(true, p + n * depth, n, depth);
}

// See crates/runtime/src/collider/solid/taper.rs.
struct Taper {
  half: f32,
  middle: f32,
  rate: f32,
  slope: f32,
  across: f32,
  along: f32,
}

fn taper(size: vec3<f32>) -> Taper {
  let length = size.y + size.y;
  let drop = size.x - size.z;
  let side = sqrt((length - drop) * (length + drop));
  return Taper(size.y, 0.5 * (size.x + size.z), -(drop / length), drop / side, side / length, drop / length);
}

fn leave_tapered(p: vec3<f32>, d: vec3<f32>, size: vec3<f32>, up: vec3<f32>, side: vec3<f32>) -> Exit {
  let cone = taper(size);
  let along = dot(d, up);
  let across = d - up * along;
  let y = clamp(along - sqrt(dot(across, across)) * cone.slope, -cone.half, cone.half);
  return leave_ball(p, d - up * y, cone.middle + y * cone.rate, side * cone.across + up * cone.along);
}

fn leave_box(p: vec3<f32>, half: vec3<f32>) -> Exit {
  let depth = half - abs(p);
  if (min(depth.x, min(depth.y, depth.z)) <= 0.0) {
    return outside();
  }
  var axis = 2u;
  if (depth.x <= depth.y && depth.x <= depth.z) {
    axis = 0u;
  } else if (depth.y <= depth.z) {
    axis = 1u;
  }
  let way = select(1.0, -1.0, p[axis] < 0.0);
  var q = p;
  var n = vec3<f32>(0.0);
  q[axis] = half[axis] * way;
  n[axis] = way;
  return Exit(true, q, n, depth[axis]);
}

fn normalized(v: vec3<f32>) -> vec3<f32> {
  return v * (1.0 / sqrt(dot(v, v)));
}

// Along the ray from the centre.
fn leave_radially(p: vec3<f32>, radii: vec3<f32>) -> Exit {
  let out = leave_ball(p / radii, p / radii, 1.0, vec3<f32>(1.0, 0.0, 0.0));
  if (!out.inside) {
    return out;
  }
  return leave_to(p, out.normal * radii, normalized(out.normal / radii));
}

// From inside to a point of the surface.
fn leave_to(p: vec3<f32>, at: vec3<f32>, normal: vec3<f32>) -> Exit {
  let way = at - p;
  return Exit(true, at, normal, sqrt(dot(way, way)));
}

// To the closest point, after D. Eberly; see crates/runtime/src/collider/solid.rs.
fn leave_ellipsoid(p: vec3<f32>, radii: vec3<f32>) -> Exit {
  let z = abs(p) / radii;
  if (dot(z, z) >= 1.0) {
    return outside();
  }
  let small = min(radii.x, min(radii.y, radii.z));
  let r = (radii / small) * (radii / small);
  let rz = select(max(z, vec3<f32>(1e-7)), z, r > vec3<f32>(1.0));
  let lowest = select(rz, vec3<f32>(0.0), r > vec3<f32>(1.0));
  var t = max(lowest.x, max(lowest.y, lowest.z));
  for (var k = 0u; k < 24u; k++) {
    let under = t + (r - 1.0);
    let a = r * rz / under;
    let g = dot(a, a) - 1.0;
    let slope = dot(2.0 * a, a / under);
    t = t + max(g / slope, 0.0);
  }
  let a = r * rz / (t + (r - 1.0));
  let n = normalized(select(a, -a, p < vec3<f32>(0.0)));
  return leave_to(p, n * radii, normalized(n / radii));
}

// Where a point inside leaves, and the normal there.
fn leave(solid: Solid, p: vec3<f32>) -> Exit {
  let d = p - solid.center;
  let up = turned(solid.rotation, vec3<f32>(0.0, 1.0, 0.0));
  if (half_spaces && solid.kind == 0u) {
    let depth = -dot(d, up);
    return Exit(depth > 0.0, p + up * depth, up, depth);
  }
  let side = turned(solid.rotation, vec3<f32>(1.0, 0.0, 0.0));
  if (spheres && solid.kind == 1u) {
    return leave_ball(p, d, solid.size.x, side);
  }
  if (capsules && solid.kind == 2u) {
    return leave_ball(p, d - up * clamp(dot(d, up), -solid.size.y, solid.size.y), solid.size.x, side);
  }
  if (tapered_capsules && solid.kind == 6u) {
    return leave_tapered(p, d, solid.size, up, side);
  }
  return leave_turned(solid, d);
}

// The same for a solid without an axis, from where the point lies beside its middle.
fn leave_turned(solid: Solid, d: vec3<f32>) -> Exit {
  let q = turned(vec4<f32>(-solid.rotation.xyz, solid.rotation.w), d);
  var out = outside();
  if (boxes && solid.kind == 3u) {
    out = leave_box(q, solid.size);
  } else if (radial_ellipsoids && solid.kind == 4u) {
    out = leave_radially(q, solid.size);
  } else if (ellipsoids && solid.kind == 5u) {
    out = leave_ellipsoid(q, solid.size);
  }
  let at = turned(solid.rotation, out.at) + solid.center;
  return Exit(out.inside, at, turned(solid.rotation, out.normal), out.depth);
}
