// The plane of a patch that comes to a particle in a frame: the point that is nearest at the start of the frame may then pass by, or be of another part of the body.
// Where a particle is at the end of a frame in which a patch comes to it.
struct Struck {
  found: bool,
  spot: Spot,
  view: View,
  // How the plane goes in the frame, in metres.
  drift: vec3<f32>,
  // The height above it that the particle keeps.
  clearance: f32,
  // The distance of the part that was nearest at the start, below 0 inside.
  other: f32,
}

// The patch that passes nearest to a particle that goes on by `goes`, measured by its extent, if one passes near: a fast one, or any if `may_be_fast` and the particle is fast.
fn passing(p: vec3<f32>, goes: vec3<f32>, may_be_fast: bool) -> u32 {
  var found = NO_TRIANGLE;
  if (rate() <= 0.0) {
    return found;
  }
  let fast = may_be_fast && dot(goes, goes) > FAST_WAY_M * FAST_WAY_M;
  let count = patch_count();
  var least = 1.0;
  for (var n = 0u; n < count; n++) {
    let middle = surface_boxes[3u * n + 2u];
    let own = vec3<f32>(surface_boxes[3u * n].w, surface_boxes[3u * n + 1u].w, middle.w);
    if (!fast && dot(own, own) <= FAST_WAY_M * FAST_WAY_M) {
      continue;
    }
    let off = middle.xyz - p;
    let way = own - goes;
    let when = min(max(-dot(off, way) / max(dot(way, way), 1e-12), 0.0), 1.0);
    let nearest = off + way * when;
    let far2 = dot(nearest, nearest);
    let share = far2 * patch_reach(n);
    if (sqrt(dot(off, off)) > sqrt(far2) + NEARER_M && share < least) {
      least = share;
      found = n;
    }
  }
  return found;
}

// Where the planes that are known leave particle k, `left` seconds before the end of the frame.
fn held_at(k: u32, p: vec3<f32>, left: f32) -> vec3<f32> {
  var held = p;
  for (var n = 0u; n < 2u; n++) {
    let row = 8u * k + 4u * n;
    let plane = found_planes[row];
    if (plane.w > NO_PLANE) {
      let at = plane.xyz - found_planes[row + 2u].xyz * left;
      let normal = found_planes[row + 1u].xyz - found_planes[row + 3u].xyz * left;
      held += normal * max(plane.w - dot(held - at, normal), 0.0);
    }
  }
  return held;
}

// Particle k at `p` goes on by `goes` and gives way to a patch, whose nearest point it follows from look to look. `nearest` is a triangle near it at the start.
fn struck_by(k: u32, n: u32, nearest: u32, p: vec3<f32>, goes: vec3<f32>, clearance: f32) -> Struck {
  var struck: Struck;
  struck.spot = walk(patch_middle(n), p);
  struck.view = view_of(struck.spot, p);
  if (struck.view.height < 0.0) {
    return struck;
  }
  var is_held = true;
  for (var half = 1u; half <= 2u; half++) {
    time = 0.5 * f32(half);
    let q = held_at(k, p + goes * time, (1.0 - time) / rate());
    is_held = is_held && view_of(walk(struck.spot.triangle, q), q).height >= clearance - HELD_M;
  }
  time = 0.0;
  if (is_held) {
    return struck;
  }
  let far = (sqrt(dot(goes, goes)) + struck.view.far) / LOOK_M;
  let looks = u32(max(ceil(min(far, LOOKS)), 1.0));
  let share = 1.0 / f32(looks);
  var q = p;
  for (var look = 1u; look <= looks; look++) {
    time = select(f32(look) * share, 1.0, look == looks);
    q += goes * share;
    struck.spot = walk(struck.spot.triangle, q);
    struck.view = view_of(struck.spot, q);
    if (look < looks && struck.view.height < clearance) {
      q += struck.view.normal * (clearance - struck.view.height);
    }
  }
  struck.other = view_of(walk(nearest, q), q).height;
  time = 0.0;
  struck.found = !struck.view.open && struck.view.height <= clearance + MARGIN_M;
  // The plane begins at the particle, or below it, and ends where the surface does.
  let off = p - (struck.view.to - struck.view.drift);
  struck.clearance = kept(k, clearance, p, off, struck.view.normal);
  struck.drift = struck.view.drift + struck.view.normal * max(struck.clearance - dot(off, struck.view.normal), 0.0);
  return struck;
}
