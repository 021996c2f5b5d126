// The collider as it is this step: where it will be at the end of the frame, moved back.
fn posed(solid: Solid) -> Solid {
  var out = solid;
  out.center = solid.center - solid.velocity * step.left;
  let half_turn = solid.spin * (-0.5 * step.left);
  let q = solid.rotation;
  let turned = vec4<f32>(half_turn * q.w + cross(half_turn, q.xyz), -dot(half_turn, q.xyz)) + q;
  out.rotation = turned * (1.0 / sqrt(dot(turned, turned)));
  return out;
}

fn out_by(at: vec3<f32>, surface: vec3<f32>, normal: vec3<f32>) -> Exit {
  let deep = dot(surface - at, normal);
  return Exit(deep > 0.0, at + normal * deep, normal, deep);
}

// After a step far shorter than the solid is thick the way out is the closest one. After a longer one it is by the plane
// that touches the solid where the path entered, or where it began inside, as resting particles do by rounding.
fn swept(solid: Solid, start: vec3<f32>, at: vec3<f32>) -> Exit {
  let path = at - start;
  let short = thickness(solid) * 0.25;
  if (dot(path, path) < short * short) {
    return leave(solid, at);
  }
  var out = outside();
  let began = leave(solid, start);
  if (began.inside) {
    out = out_by(at, began.at, began.normal);
  } else {
    let hit = enter(solid, start, path);
    if (hit.t <= 1.0) {
      out = out_by(at, start + path * hit.t, hit.normal);
    }
  }
  if (out.inside) {
    return out;
  }
  return leave(solid, at);
}

// Where a particle that went from `was` to `p` is put by the colliders, one after the other.
fn cleared(p: vec3<f32>, was: vec3<f32>) -> vec3<f32> {
  var at = p;
  var moved = false;
  var c = near_from(0u);
  while (c < solid_count()) {
    let solid = posed(solid_at(c));
    let start = moved_by(solid, was);
    let out = swept(solid, start, at);
    if (out.inside) {
      // A solid is convex, and friction moves the particle at right angles to its normal: the particle stays outside.
      at = rub(solid, out, start);
      moved = true;
    }
    // Where one has put it, others may be near that were not.
    if (moved) {
      c = near_to(c + 1u, at, was);
    } else {
      c = near_from(c + 1u);
    }
  }
  return at;
}
