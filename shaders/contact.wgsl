// Particles inside a moving collider, or on its other side, go to its surface, collider by collider.
@group(0) @binding(2) var<storage, read_write> now: array<vec4<f32>>;

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
  return Exit(deep > 0.0, at + normal * deep, normal);
}

// A step shorter than the solid is thick cannot pass it: the closest way out is right. A longer one leaves by the plane
// that touches the solid where the path entered, or where it began inside.
fn swept(solid: Solid, start: vec3<f32>, at: vec3<f32>) -> Exit {
  let path = at - start;
  let thick = thickness(solid);
  if (dot(path, path) < thick * thick) {
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
  let p = now[k];
  if (p.w <= 0.0) {
    return;
  }
  var at = p.xyz;
  let was = before[k].xyz;
  for (var c = 0u; c < arrayLength(&solids); c++) {
    let solid = posed(solids[c]);
    let start = was + (solid.velocity + cross(solid.spin, was - solid.center)) * step.dt;
    let out = swept(solid, start, at);
    if (out.inside) {
      let depth = out.at - at;
      at = rub(solid, k, out.at, out.normal, sqrt(dot(depth, depth)));
      let again = leave(solid, at);
      at = select(at, again.at, again.inside);
    }
  }
  now[k] = vec4<f32>(at, p.w);
}
