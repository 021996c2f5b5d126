// Where a collider carries a point in a step.
fn moved_by(solid: Solid, p: vec3<f32>) -> vec3<f32> {
  return p + (solid.velocity + cross(solid.spin, p - solid.center)) * step.dt;
}

// Takes back the motion along the surface since the last step, by at most friction times the depth; `start` is where the
// collider carried the particle from where it was.
fn rub(solid: Solid, out: Exit, start: vec3<f32>) -> vec3<f32> {
  if (solid.friction <= 0.0) {
    return out.at;
  }
  let moved = out.at - start;
  let along = moved - out.normal * dot(moved, out.normal);
  let far = sqrt(dot(along, along));
  let most = solid.friction * out.depth;
  if (far <= most) {
    return out.at - along;
  }
  return out.at - along * (most / far);
}
