// The planes that the particles of a cloth on the surface of a body meet in a frame, a thread a particle, at the start of the frame: each particle
// walks to the nearest point of the surface from where that was in the last frame.
//
// `wearers` has four rows per particle: the height that it keeps, its number or that of its first duplicate, the pin that holds it and how far along the
// cloth that is; its neighbours in the grid, each by its first duplicate; those that are some cells away; and the lengths of cloth up to these at rest, 0
// where a spring is missing.
// `surface_hints` has five rows per particle: where it was; the way from the nearest point to it, where on the triangle that is, and the frames for which it waits; the weights there; and twice the normal and the triangle, for odd and even frames. The first and the third row have the
// second side too, for even and odd frames.
// `found_planes` has two planes per particle, as shaders/surface_contact.wgsl reads them.
@group(0) @binding(2) var<storage, read> now: array<vec4<f32>>;
@group(0) @binding(94) var<storage, read> surface_vertices: array<vec4<f32>>;
@group(0) @binding(96) var<storage, read> surface_boxes: array<vec4<f32>>;
@group(0) @binding(97) var<storage, read_write> surface_hints: array<vec4<u32>>;
@group(0) @binding(98) var<storage, read> wearers: array<vec4<u32>>;
@group(0) @binding(99) var<storage, read_write> found_planes: array<vec4<f32>>;

// A point of the surface, seen from a particle, at the start of a frame or at another time in it.
struct View {
  // The end of the point's way in the frame, and the way.
  to: vec3<f32>,
  drift: vec3<f32>,
  normal: vec3<f32>,
  // From the point to the particle.
  off: vec3<f32>,
  // The distance of the particle, below 0 inside, and how far it is beside the normal.
  height: f32,
  beside: f32,
  // The length of the way.
  far: f32,
  // Whether the normal is the direction of the particle, and whether that is beside a border.
  straight: bool,
  open: bool,
}

// The nearest point and the second side that a particle knows.
struct Known {
  spot: Spot,
  view: View,
  second: u32,
}

// Seconds of a frame by which the surface moves, as their inverse; 0 if it does not move.
fn rate() -> f32 {
  return action[0].x;
}

// Frames since all particles searched among all patches, by SEARCH_FRAMES.
fn frames() -> u32 {
  return u32(action[0].y);
}

// The row with the second side that a particle knew before this frame (`later` is 0), or that it knows then (1): neighbours read the first one meanwhile.
fn second_row(particle: u32, later: u32) -> u32 {
  return 5u * particle + 2u * ((frames() + later) & 1u);
}

// The fourth number of a row is another one's.
fn put_hint(row: u32, v: vec3<f32>) {
  surface_hints[row].x = bitcast<u32>(v.x);
  surface_hints[row].y = bitcast<u32>(v.y);
  surface_hints[row].z = bitcast<u32>(v.z);
}

fn is_afresh() -> bool {
  return action[0].z > 0.0;
}

// The mean of a row of the corners of a triangle.
fn mixed(corners: vec3<u32>, row: u32, weights: vec3<f32>) -> vec3<f32> {
  return surface_vertices[4u * corners.x + row].xyz * weights.x
    + surface_vertices[4u * corners.y + row].xyz * weights.y
    + surface_vertices[4u * corners.z + row].xyz * weights.z;
}

// The mean of the normals of the corners of a triangle.
fn mixed_normal(corners: vec3<u32>, weights: vec3<f32>) -> vec3<f32> {
  if (time > 0.0) {
    return at_time(surface_vertices[4u * corners.x + 2u].xyz, surface_vertices[4u * corners.x + 3u].xyz) * weights.x
      + at_time(surface_vertices[4u * corners.y + 2u].xyz, surface_vertices[4u * corners.y + 3u].xyz) * weights.y
      + at_time(surface_vertices[4u * corners.z + 2u].xyz, surface_vertices[4u * corners.z + 3u].xyz) * weights.z;
  }
  return mixed(corners, 2u, weights);
}

fn face_normal_at_end(corners: vec3<u32>) -> vec3<f32> {
  let a = end_of(corners.x);
  return direction(cross(end_of(corners.y) - a, end_of(corners.z) - a));
}

fn is_border(spot: Spot) -> bool {
  if (spot.on == 0u) {
    return false;
  }
  if (spot.on <= 3u) {
    return surface_triangles[2u * spot.triangle + 1u][spot.on - 1u] == NO_TRIANGLE;
  }
  return (surface_triangles[2u * spot.triangle].w >> (spot.on - 1u) & 1u) == 1u;
}

fn view_of(spot: Spot, p: vec3<f32>) -> View {
  let corners = surface_triangles[2u * spot.triangle].xyz;
  var view: View;
  let start = mixed(corners, 0u, spot.weights);
  view.to = mixed(corners, 1u, spot.weights);
  view.off = p - start;
  if (time > 0.0) {
    view.off = p - at_time(start, view.to);
  }
  let far2 = dot(view.off, view.off);
  let far = sqrt(far2);
  if (spot.on == 0u) {
    let t = corners_of(spot.triangle);
    view.normal = direction(cross(t.b - t.a, t.c - t.a));
  } else {
    let smooth_normal = direction(mixed_normal(corners, spot.weights));
    let up = dot(view.off, smooth_normal);
    view.open = is_border(spot) && abs(up) < OPEN_COSINE * far;
    view.straight = up > 0.0 && far > ON_SURFACE_M;
    view.normal = smooth_normal;
    if (view.straight) {
      view.normal = view.off * (1.0 / far);
    }
  }
  let up = dot(view.off, view.normal);
  view.height = select(far, -far, up < 0.0);
  view.beside = sqrt(max(far2 - up * up, 0.0));
  view.drift = view.to - start;
  view.far = sqrt(dot(view.drift, view.drift));
  return view;
}

// The triangle nearest to `p`, by the boxes that may have it.
fn search(p: vec3<f32>) -> u32 {
  let count = patch_count();
  var first = 0u;
  var far = 3.4e38;
  for (var n = 0u; n < count; n++) {
    let d = apart(n, p);
    if (d < far) {
      far = d;
      first = n;
    }
  }
  var best = vec2<u32>(ordered_triangle(patch_start(first)), bitcast<u32>(3.4e38f));
  best = nearest_of(first, p, best);
  for (var n = 0u; n < count; n++) {
    if (n != first && apart(n, p) < bitcast<f32>(best.y)) {
      best = nearest_of(n, p, best);
    }
  }
  return best.x;
}

// The squared distance of a point from the box of a patch.
fn apart(n: u32, p: vec3<f32>) -> f32 {
  let d = max(max(surface_boxes[3u * n].xyz - p, p - surface_boxes[3u * n + 1u].xyz), vec3<f32>(0.0));
  return dot(d, d);
}

// The nearest triangle so far and the bits of its squared distance, with those of a patch.
fn nearest_of(n: u32, p: vec3<f32>, so_far: vec2<u32>) -> vec2<u32> {
  var best = so_far;
  let end = patch_start(n + 1u);
  for (var k = patch_start(n); k < end; k++) {
    let triangle = ordered_triangle(k);
    let far2 = on_triangle(p, triangle).far2;
    if (far2 < bitcast<f32>(best.y)) {
      best = vec2<u32>(triangle, bitcast<u32>(far2));
    }
  }
  return best;
}

// The patch with the middle nearest to `p`.
fn patch_of(p: vec3<f32>) -> u32 {
  let count = patch_count();
  var best = 0u;
  var far = 3.4e38;
  for (var n = 0u; n < count; n++) {
    let d = surface_boxes[3u * n + 2u].xyz - p;
    let far2 = dot(d, d);
    if (far2 < far) {
      far = far2;
      best = n;
    }
  }
  return best;
}

// The nearest point from where the last one was.
fn first_of(k: u32, mark: vec4<u32>, p: vec3<f32>) -> Known {
  var known: Known;
  if (mark.w == NO_TRIANGLE) {
    known.second = NO_TRIANGLE;
    known.spot = walk(search(p), p);
    known.view = view_of(known.spot, p);
    return known;
  }
  known.second = surface_hints[second_row(k, 0u)].w;
  let last = surface_hints[5u * k + 1u];
  let on = last.w & 255u;
  known.spot = Spot(bitcast<vec3<f32>>(surface_hints[5u * k + 2u].xyz), 0.0, mark.w, on);
  known.view = view_of(known.spot, p);
  let height = known.view.height;
  // Near a side or a corner the surface bends, and the next face may be nearer already.
  let bends = on != 0u && height < MARGIN_M;
  if (height > -BESIDE_M && !known.view.open && !bends) {
    // Beside the way of the walk; without it a side or a corner would always be straight below.
    let way = bitcast<vec3<f32>>(last.xyz);
    let off = cross(way, known.view.normal);
    let beside = select(sqrt(dot(off, off)), known.view.beside, on == 0u);
    if (beside < BESIDE_M + BESIDE_PER_HEIGHT * max(height, 0.0)) {
      if (on != 0u) {
        known.view.off = way;
      }
      return known;
    }
  }
  known.spot = walk(mark.w, p);
  known.view = view_of(known.spot, p);
  return known;
}

// Whether a point is of another side of the surface than the nearest one, and near enough to be met.
fn is_second(nearest: View, other: View) -> bool {
  return abs(other.height) < SECOND_M && dot(nearest.normal, other.normal) < SECOND_COSINE;
}

// Takes the point that a walk from another triangle finds if it is nearer; the farther one becomes the second, if it is of another side.
fn compared(known: Known, start: u32, p: vec3<f32>) -> Known {
  let other = walk(start, p);
  if (other.triangle == known.spot.triangle) {
    return known;
  }
  let side = view_of(other, p);
  let nearer = abs(side.height) < abs(known.view.height);
  var best = known;
  if (is_second(known.view, side)) {
    best.second = select(other.triangle, known.spot.triangle, nearer);
  }
  if (nearer) {
    best.spot = other;
    best.view = side;
  }
  return best;
}

// The height that particle k at `p` keeps above a point of the surface; `off` is the vector from that point to the particle. If a pose puts the pin that
// holds the particle deeper into the body than it was modelled, the height is at most what the length of cloth between the particle and the pin allows.
fn kept(k: u32, clearance: f32, p: vec3<f32>, off: vec3<f32>, normal: vec3<f32>) -> f32 {
  let own = wearers[4u * k];
  if (own.z >= arrayLength(&now)) {
    return clearance;
  }
  let pin = now[own.z];
  let most = bitcast<f32>(own.w);
  let modelled = max(-bitcast<f32>(wearers[4u * own.z].x), 0.0);
  let height = dot(pin.xyz - p + off, normal) + modelled;
  let slant = SLANT * min(max((SLANT_M + SLANT_M - most) / SLANT_M, 0.0), 1.0);
  return select(clearance, min(clearance, height + min(height, 0.0) * slant + most), pin.w <= 0.0);
}

// How much deeper than else particle k at `p` may be: contact gives way where it would stretch cloth without end.
fn give(k: u32, p: vec3<f32>) -> f32 {
  let pin = wearers[4u * k].z;
  if (pin >= arrayLength(&now) || now[pin].w > 0.0 || action[1].w <= 0.0) {
    return 0.0;
  }
  var most = 0.0;
  for (var side = 0u; side < 4u; side++) {
    let span = bitcast<f32>(wearers[4u * k + 3u][side]);
    if (span > 0.0) {
      let way = now[wearers[4u * k + 2u][side]].xyz - p;
      most = max(most, sqrt(dot(way, way)) - CAUGHT * span);
      let step = now[wearers[4u * k + 1u][side]].xyz - p;
      most = max(most, sqrt(dot(step, step)) - CAUGHT_BESIDE * span);
    }
  }
  return most * CAUGHT_GIVE;
}

// Whether a particle may meet a plane in a frame.
fn is_met(view: View, reach: f32) -> bool {
  return !view.open && view.height <= reach + view.far && view.height > -LOST_M;
}

// Whether a particle meets the plane of a second side. A walk that ends where a wall does sees no inside from there.
fn is_met_beside(spot: Spot, view: View) -> bool {
  return !view.open && view.height > -LOST_M && (spot.on == 0u || view.height > -MARGIN_M);
}

fn at_rest(vertex: u32) -> vec3<f32> {
  let row = 4u * vertex;
  return vec3<f32>(surface_vertices[row].w, surface_vertices[row + 1u].w, surface_vertices[row + 2u].w);
}

// Whether two points are on two sides of one part of the body, such as a plate or the rim of a neck: at rest neither is in front of the face of the
// other. Walls of a crease are, or are farther from each other there than now, where they are `apart`, such as a heel and a robe.
fn is_back(one: Spot, other: Spot, apart: vec3<f32>) -> bool {
  let one_corners = surface_triangles[2u * one.triangle].xyz;
  let other_corners = surface_triangles[2u * other.triangle].xyz;
  let a = mat3x3<f32>(at_rest(one_corners.x), at_rest(one_corners.y), at_rest(one_corners.z));
  let b = mat3x3<f32>(at_rest(other_corners.x), at_rest(other_corners.y), at_rest(other_corners.z));
  let way = b * other.weights - a * one.weights;
  let far = sqrt(dot(way, way));
  if (far > sqrt(dot(apart, apart)) * BACK_WAYS) {
    return false;
  }
  let there = dot(way, direction(cross(a[1] - a[0], a[2] - a[0])));
  let here = dot(-way, direction(cross(b[1] - b[0], b[2] - b[0])));
  return max(there, here) < LEVEL_SINE * far && min(there, here) < BACK_SINE * far;
}

// The clearance between two sides that face each other, such as an arm and a chest: half of the gap between them, at its narrowest in the frame, as
// both clearances may not fit. Where the sides overlap it is 0: particles go out of the crease from step to step, and stay on the first side, at which
// they are.
fn squeezed(first: View, last: View, clearance: f32) -> f32 {
  let closes = max(dot(first.drift - last.drift, first.normal), 0.0);
  return min(max(0.5 * (first.height + last.height - closes), 0.0), clearance);
}

// The plane at a point of the surface.
fn put_plane(n: u32, spot: Spot, view: View, clearance: f32) {
  var last = view.normal;
  if (rate() > 0.0) {
    let corners = surface_triangles[2u * spot.triangle].xyz;
    if (spot.on == 0u) {
      last = face_normal_at_end(corners);
    } else {
      last = direction(mixed(corners, 3u, spot.weights));
      if (view.straight) {
        last = direction(view.normal + (last - direction(mixed(corners, 2u, spot.weights))));
      }
    }
  }
  found_planes[n] = vec4<f32>(view.to, clearance);
  // The friction of the cloth.
  found_planes[n + 1u] = vec4<f32>(last, action[1].z);
  found_planes[n + 2u] = vec4<f32>(view.drift * rate(), 0.0);
  found_planes[n + 3u] = vec4<f32>((last - view.normal) * rate(), 0.0);
}

fn put_planes(k: u32, mark: vec4<u32>, p: vec3<f32>) {
  let own = wearers[4u * k];
  let clearance = bitcast<f32>(own.x) - give(k, p);
  let was_known = mark.w != NO_TRIANGLE;
  let moved = p - bitcast<vec3<f32>>(surface_hints[5u * k].xyz);
  let way = sqrt(dot(moved, moved));
  let reach = clearance + MARGIN_M + select(UNKNOWN_WAY_M, WAYS * way, was_known);
  var known = first_of(k, mark, p);
  // A particle that comes nearer to another wall still has the one that it was at.
  if (was_known && dot(bitcast<vec3<f32>>(mark.xyz), known.view.normal) < SECOND_COSINE) {
    known.second = mark.w;
  }
  // The nearest of those that a patch brought near in the last frame.
  let before = surface_hints[second_row(k, 0u)].w;
  if (was_known && before != NO_TRIANGLE && way + known.view.far > FAST_M) {
    known = compared(known, before, p);
  }
  // One neighbour in each of four frames.
  let beside = wearers[4u * k + 1u][frames() & 3u];
  if (beside != NO_TRIANGLE && !is_afresh()) {
    let other = surface_hints[5u * beside + 3u + (frames() & 1u)];
    if (other.w != NO_TRIANGLE && dot(bitcast<vec3<f32>>(other.xyz), known.view.normal) < SAME_COSINE) {
      known = compared(known, other.w, p);
    }
    if (known.second == NO_TRIANGLE) {
      known.second = surface_hints[second_row(beside, 0u)].w;
    }
  }
  // Another part of the body may have come where a particle knows none near.
  let is_due = (own.y + frames()) % SEARCH_FRAMES == 0u || (known.view.height > reach && way + known.view.far > FAST_M);
  if (was_known && is_due) {
    let nearest = patch_of(p);
    if (surface_triangles[2u * known.spot.triangle + 1u].w != nearest) {
      known = compared(known, patch_middle(nearest), p);
    }
  }
  let meets = is_met(known.view, reach);
  if (meets) {
    put_plane(8u * k, known.spot, known.view, kept(k, clearance, p, known.view.off, known.view.normal));
  }
  var is_crease = false;
  if (known.second != NO_TRIANGLE) {
    let other = walk_beyond(known.second, p, known.view.normal);
    let side = view_of(other, p);
    let is_other = abs(side.height) < SECOND_M && faces_away(other.triangle, known.view.normal)
      && !(side.height < 0.0 && is_back(known.spot, other, side.off - known.view.off));
    known.second = select(NO_TRIANGLE, other.triangle, is_other);
    // However far it is: a particle in a crease may be thrown from one wall to the other in a frame.
    is_crease = is_other && is_met_beside(other, side);
    if (is_crease) {
      put_plane(8u * k + 4u, other, side, kept(k, clearance, p, side.off, side.normal));
      if (meets && dot(known.view.normal, side.normal) < FACING_COSINE) {
        let half = squeezed(known.view, side, clearance);
        found_planes[8u * k].w = min(found_planes[8u * k].w, half);
        found_planes[8u * k + 4u].w = min(found_planes[8u * k + 4u].w, half);
      }
    }
  }
  var struck: Struck;
  if (was_known) {
    let comes = passing(p, moved, true);
    if (comes != NO_TRIANGLE) {
      struck = struck_by(k, comes, known.spot.triangle, p, moved, clearance);
    }
  }
  if (struck.found) {
    if (meets && !is_crease) {
      for (var row = 0u; row < 4u; row++) {
        found_planes[8u * k + 4u + row] = found_planes[8u * k + row];
      }
    }
    found_planes[8u * k] = vec4<f32>(struck.view.to, struck.clearance);
    found_planes[8u * k + 1u] = vec4<f32>(struck.view.normal, action[1].z);
    found_planes[8u * k + 2u] = vec4<f32>(struck.drift * rate(), 0.0);
    found_planes[8u * k + 3u] = vec4<f32>(0.0);
  }
  var wait = 0u;
  if (was_known) {
    let nearer = way + known.view.far + FASTER_M;
    wait = u32(max(min((known.view.height - reach - known.view.far) / nearer, MAX_WAIT), 0.0));
  }
  if (struck.found) {
    let nearer = abs(struck.view.height) < abs(struck.other);
    let first = known.spot.triangle;
    if (nearer) {
      known.spot = struck.spot;
      known.view = struck.view;
    }
    if (known.second == NO_TRIANGLE || known.second == known.spot.triangle) {
      known.second = select(struck.spot.triangle, first, nearer);
    }
  }
  put_hint(5u * k, p);
  surface_hints[5u * k + 1u] = vec4<u32>(bitcast<vec3<u32>>(known.view.off), known.spot.on | wait << 8u);
  put_hint(5u * k + 2u, known.spot.weights);
  surface_hints[second_row(k, 1u)].w = known.second;
  surface_hints[5u * k + 4u - (frames() & 1u)] = vec4<u32>(bitcast<vec3<u32>>(known.view.normal), known.spot.triangle);
}

@compute @workgroup_size(64)
fn main(
  @builtin(workgroup_id) workgroup: vec3<u32>,
  @builtin(num_workgroups) rows: vec3<u32>,
  @builtin(local_invocation_index) local: u32,
) {
  let k = element(workgroup, rows, local);
  if (k >= arrayLength(&now)) {
    return;
  }
  found_planes[8u * k].w = NO_PLANE;
  found_planes[8u * k + 4u].w = NO_PLANE;
  var mark = surface_hints[5u * k + 3u + (frames() & 1u)];
  if (is_afresh()) {
    mark.w = NO_TRIANGLE;
    surface_hints[5u * k + 1u].w = 0u;
  }
  let p = now[k];
  let met = bitcast<f32>(wearers[4u * k].x) >= -MODELLED_INSIDE_M;
  let state = surface_hints[5u * k + 1u].w;
  var waits = met && p.w > 0.0 && state >> 8u > 0u;
  if (waits) {
    surface_hints[5u * k + 1u].w = state - 256u;
    waits = passing(p.xyz, p.xyz - bitcast<vec3<f32>>(surface_hints[5u * k].xyz), false) == NO_TRIANGLE;
  }
  if (!met || p.w <= 0.0 || waits) {
    surface_hints[5u * k + 4u - (frames() & 1u)] = mark;
    surface_hints[second_row(k, 1u)].w = select(surface_hints[second_row(k, 0u)].w, NO_TRIANGLE, is_afresh());
    return;
  }
  put_planes(k, mark, p.xyz);
}
