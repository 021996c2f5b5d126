// Takes back the motion along the surface since the last step, by at most friction times the depth.
fn rub(solid: Solid, at: vec3<f32>, n: vec3<f32>, depth: f32, was: vec3<f32>) -> vec3<f32> {
  if (solid.friction <= 0.0) {
    return at;
  }
  let surface = solid.velocity + cross(solid.spin, at - solid.center);
  let moved = at - was - surface * step.dt;
  let along = moved - n * dot(moved, n);
  let far = sqrt(dot(along, along));
  let most = solid.friction * depth;
  if (far <= most) {
    return at - along;
  }
  return at - along * (most / far);
}
