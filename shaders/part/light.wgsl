// Light from sky and ground, a lamp, one at the eye, and the sheen that fibres have at the outline.
fn lit(base: vec3<f32>, n: vec3<f32>, at: vec3<f32>) -> vec3<f32> {
  let d = view.eye - at;
  let to_eye = d * (1.0 / max(sqrt(dot(d, d)), 1e-9));
  let facing = clamp(dot(n, to_eye), 0.0, 1.0);
  let sky = 0.32 + 0.12 * n.y;
  let lamp = 0.62 * max(dot(n, view.light), 0.0);
  let edge = (1.0 - facing) * (1.0 - facing) * (1.0 - facing);
  return base * (sky + lamp + 0.14 * facing) + vec3<f32>(0.05 * edge);
}

// Linear light as sRGB.
fn encoded(linear: vec3<f32>) -> vec3<f32> {
  let c = clamp(linear, vec3<f32>(0.0), vec3<f32>(1.0));
  let curved = 1.055 * pow(c, vec3<f32>(1.0 / 2.4)) - 0.055;
  return select(curved, c * 12.92, c <= vec3<f32>(0.0031308));
}
